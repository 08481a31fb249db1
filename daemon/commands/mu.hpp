#pragma once
// The points of campaigns, which "shakerd mu" and "shakerd law" fit, and "shakerd report" too.
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "daemon/law/findings.hpp"
#include "daemon/sandbox/confined.hpp"

namespace shaker::commands {

/// The points table of a campaign: FOLDER/campaign.nxs, or the file itself. InputError when it does not
/// exist.
std::filesystem::path points_file(const std::filesystem::path& campaign);

/// Rights of a child that reads these points tables.
sandbox::Confinement confinement_for_points(const std::vector<std::filesystem::path>& files);

struct MuOptions {
    double gravity = NAN;   // m/s^2; NaN: of the campaigns' benches, which must be the same for all
    bool free_tilt = true;  // see CoulombOptions
};
/// Reads the points of campaigns (folders, or their points tables) and of recordings and fits them together:
/// the fits, budgets and remarks as text or JSON. InputError that names the file for one that is neither, for
/// a damaged one, for one without a measured point, and for one at another place.
std::string mu_text(const std::vector<std::filesystem::path>& campaigns, const MuOptions& options, bool json);
/// The same for the laws of friction: which describes the points.
std::string law_text(const std::vector<std::filesystem::path>& campaigns, const MuOptions& options,
                     bool json);

}  // namespace shaker::commands
