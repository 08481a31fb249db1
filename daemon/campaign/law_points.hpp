#pragma once
// The measured points of a campaign, for the fits to the law of friction.
#include <vector>

#include "daemon/campaign/points_table.hpp"
#include "daemon/law/point.hpp"

namespace shaker::campaign {

/// The measured points with a finite v_D and base; others are left out. campaign: its index among several.
std::vector<law::Point> law_points(const PointsTable& table, int campaign = 0);

}  // namespace shaker::campaign
