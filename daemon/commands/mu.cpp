#include "daemon/commands/mu.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>

#include "daemon/campaign/campaign_folder.hpp"
#include "daemon/campaign/point_results.hpp"
#include "daemon/commands/table.hpp"
#include "daemon/manual/values.hpp"
#include "daemon/report/printing.hpp"
#include "drivers/errors.hpp"

namespace shaker::commands {

namespace {

using manual::Argument;
using manual::Kind;

constexpr std::array mu_arguments{
    Argument{.name = "CAMPAIGN",
             .help = "Folder of a campaign, or its points table campaign.nxs; several are fitted together",
             .kind = Kind::file,
             .many = true},
    Argument{.name = "--gravity",
             .value = "ACCELERATION",
             .help = "Gravity at the place, e.g. 9.83m/s^2",
             .kind = Kind::quantity,
             .dimension = Dimension::acceleration,
             .allowed = {0.1, 100},
             .otherwise = "that of the bench: gravity_mps2 in its rig file, or 9.8 m/s^2"},
    Argument{.name = "--level", .help = "Take the base as level also where mirror partners show its tilt"},
    manual::json_argument};

int act_on_mu(const manual::Values& values) {
    std::vector<std::filesystem::path> files;
    for (const std::string& name : values.texts("CAMPAIGN")) files.push_back(points_file(name));
    return confined(files.front().string(), confinement_for_points(files), [&] {
        report::say(mu_text(files,
                            {.gravity = values.has("--gravity") ? values.number("--gravity") : NAN,
                             .free_tilt = !values.has("--level")},
                            values.has("--json")));
        return manual::exit_ok;
    });
}

}  // namespace

std::filesystem::path points_file(const std::filesystem::path& campaign) {
    const bool folder = std::filesystem::is_directory(campaign);
    std::filesystem::path file = folder ? campaign / campaign::table_name : campaign;
    if (std::filesystem::exists(file)) return file;
    if (folder)
        throw InputError{fmt::format(
            "{}: the folder has no {}; \"shakerd campaign {} --reduce\" makes one from the recordings",
            campaign.string(), campaign::table_name, campaign.string())};
    throw InputError{fmt::format("{}: no such file or folder", campaign.string())};
}

std::string mu_text(const std::vector<std::filesystem::path>& campaigns, const MuOptions& options,
                    bool json) {
    std::vector<law::Point> points;
    double place = NAN;  // gravity of the campaigns so far
    for (std::size_t i = 0; i < campaigns.size(); ++i) {
        const std::filesystem::path file = points_file(campaigns[i]);
        if (!campaign::has_points(file))
            throw InputError{
                fmt::format("{}: expected the folder of a campaign or its points table campaign.nxs",
                            campaigns[i].string())};
        const campaign::PointsTable table = campaign::read_points(file);
        if (std::isnan(options.gravity) && std::isfinite(place) && table.gravity != place)
            throw InputError{fmt::format(
                "{}: gravity is {} m/s^2, {} m/s^2 in the campaign before; fit them apart, or give "
                "--gravity",
                campaigns[i].string(), table.gravity, place)};
        place = table.gravity;
        std::vector<law::Point> own = campaign::law_points(table, static_cast<int>(i));
        if (own.empty())
            throw InputError{fmt::format("{}: the campaign has no measured point", campaigns[i].string())};
        points.insert(points.end(), std::make_move_iterator(own.begin()), std::make_move_iterator(own.end()));
    }
    const law::Findings findings = law::analyse(
        std::move(points),
        {.g = std::isnan(options.gravity) ? place : options.gravity, .free_tilt = options.free_tilt});
    return json ? findings_json(findings) : findings_text(findings);
}

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
        .arguments = mu_arguments,
        .example = "shakerd mu paper",
        .exit_statuses = {manual::exit_device},
        .act = act_on_mu};
}

}  // namespace shaker::commands
