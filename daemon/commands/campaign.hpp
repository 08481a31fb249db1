#pragma once
// The command "campaign": checks a plan, measures it, continues it, or makes its points table again.
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string>
#include <string_view>

#include "daemon/campaign/plan.hpp"
#include "daemon/run/run_settings.hpp"

namespace shaker::commands {

struct CampaignOptions {
    std::filesystem::path plan;    // empty when a campaign is continued: its folder has it
    std::string_view plan_text{};  // of `plan`; empty: it is read
    std::filesystem::path folder;  // of the campaign
    run::RunOptions run;
    /// Length of the cameras' view, for the check of a plan; NaN: that of the simulated bench.
    double view_m = NAN;
    bool json = false;
    std::FILE* lines_to = stdout;  // of the campaign
};

/// The text of daemon/campaign/plans/response.toml.
extern const std::string_view response_plan;

/// Prints points, order, predicted travel, bench time and bytes; nothing moves. InputError for a plan beyond
/// the limits of the bench.
void check_plan(const CampaignOptions& options);
/// The command line that goes on with a campaign that has paused.
std::string go_on(const CampaignOptions& options);
/// Measures the points of a plan into a new folder, or the remaining points of a campaign.
/// InputError for a plan that cannot be read or is beyond the limits, and for a folder in use. TripError when
/// the drive has tripped and nobody is there to clear the trip.
void measure_campaign(const CampaignOptions& options);
/// Makes the points table again from the recordings. working: the new table, written there (true); empty:
/// it is compared with that of the folder; true: identical.
bool reduce_campaign(const std::filesystem::path& folder, const std::filesystem::path& working = {});

}  // namespace shaker::commands
