#pragma once
// The command "mu": the friction coefficient three ways, and all other fits, from the points of campaigns.
#include <filesystem>
#include <string>
#include <vector>

#include "daemon/law/findings.hpp"

namespace shaker::commands {

struct MuOptions {
    std::vector<std::filesystem::path> campaigns{};  // folders, or their points tables
    law::CoulombOptions law{};
    law::InputErrors errors{};
    bool json = false;
};

/// The points table of a campaign: FOLDER/campaign.nxs, or the file itself. InputError when it does not
/// exist.
std::filesystem::path points_file(const std::filesystem::path& campaign);

/// Reads the points of all campaigns and fits them together: the fits, budgets and remarks as text or JSON.
/// InputError that names the file for one that is not a points table, for a damaged one, and for one without
/// a measured point.
std::string mu_text(const MuOptions& options);
/// Prints it.
void print_mu(const MuOptions& options);

}  // namespace shaker::commands
