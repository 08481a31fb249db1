#pragma once
// The points table of a campaign from its journal and its recordings; and its measured points for the fits to
// the law of friction.
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "daemon/campaign/plan.hpp"
#include "daemon/campaign/points_table.hpp"
#include "daemon/campaign/progress.hpp"
#include "daemon/law/point.hpp"

namespace shaker::campaign {

/// Where the results of the measurements come from.
enum class Source {
    stored,  // the results that the recordings have: fast
    raw,  // computed again from the pictures of the recordings or, where these were not kept, from the tracks
};

struct PointResults {
    PointsTable table;
    /// Source of each recording, and passes without results; one sentence each.
    std::vector<std::string> remarks;
    /// Passes with a measurement that their recordings do not have, with the reason.
    std::vector<PassLost> lost;
};

/// The rows of points that are not measured yet: number, series, repeat, partner and set-point.
std::vector<PointRow> asked_rows(std::span<const Point> points);

/// A sensor has one corner: a point without a doubt whose own differs from the median of the others at its
/// frequency (three or more) by more than five standard errors gets one.
void name_other_corners(std::vector<PointRow>& rows);

/// The rows of the points of a plan. asked: for each point its number, series, repeat, partner and set-point.
/// A pass whose recording has no result for it is not in the result of its point, and a measured point
/// without any other pass counts as failed. InputError for a recording that is damaged or is newer than this
/// program.
PointResults point_results(const std::filesystem::path& folder, std::span<const PointRow> asked,
                           const Progress& progress, Source source);

/// The measured points with a finite v_D and base; others are left out. campaign: its index among several.
std::vector<law::Point> law_points(const PointsTable& table, int campaign = 0);

}  // namespace shaker::campaign
