#include <algorithm>

#include "daemon/command_line/confined_mu.hpp"
#include "daemon/command_line/rows.hpp"
#include "daemon/commands/mu/mu_command.hpp"

namespace shaker::command_line {

namespace {

using manual::Argument;
using manual::Kind;

constexpr std::array arguments{
    Argument{.name = "CAMPAIGN",
             .help = "Folder of a campaign, or its points table campaign.nxs; several are fitted together",
             .kind = Kind::file,
             .many = true},
    Argument{.name = "--level", .help = "Take the base as level also where mirror partners show its tilt"},
    json_argument};

int act(const manual::Values& values) {
    commands::MuOptions options;
    for (const std::string& name : values.texts("CAMPAIGN")) options.campaigns.emplace_back(name);
    options.law.free_tilt = !values.has("--level");
    options.json = values.has("--json");
    std::vector<std::filesystem::path> files;
    for (const std::filesystem::path& campaign : options.campaigns)
        files.push_back(commands::points_file(campaign));
    options.campaigns = files;
    return confined(files.front().string(), confinement_for_points(files), [&] {
        print_mu(options);
        return manual::exit_ok;
    });
}

}  // namespace

sandbox::Confinement confinement_for_points(const std::vector<std::filesystem::path>& files) {
    sandbox::Confinement allowed = sandbox::confinement_for(files.front());
    for (const std::filesystem::path& file : files) {
        const sandbox::Confinement more = sandbox::confinement_for(file);
        allowed.memory_bytes = std::max(allowed.memory_bytes, more.memory_bytes);
        allowed.processor_s = std::max(allowed.processor_s, more.processor_s);
        allowed.files.reads.insert(allowed.files.reads.end(), more.files.reads.begin(),
                                   more.files.reads.end());
    }
    return allowed;
}

manual::Command mu_row() {
    return {
        .name = "mu",
        .summary = "Fit the friction coefficient to the points of campaigns",
        .details =
            "mu_ac: exact Coulomb law at the measured drives, with tilt and the walker's push on the base. "
            "mu_k: slopes of v(t) in slips. mu_ns: the paper's no-stick formula, 13 to 23 % too low. Budgets "
            "list the sources of uncertainty, largest first; those marked as estimates are defaults.",
        .arguments = arguments,
        .example = "shakerd mu paper",
        .exit_statuses = {manual::exit_device},
        .act = act};
}

}  // namespace shaker::command_line
