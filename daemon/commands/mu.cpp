#include "daemon/commands/mu.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "daemon/campaign/campaign_folder.hpp"
#include "daemon/campaign/point_results.hpp"
#include "daemon/campaign/run_points.hpp"
#include "daemon/commands/table.hpp"
#include "daemon/law/verdict.hpp"
#include "daemon/manual/values.hpp"
#include "daemon/report/printing.hpp"
#include "drivers/errors.hpp"

namespace shaker::commands {

namespace {

using manual::Argument;
using manual::Kind;

constexpr std::array mu_arguments{
    Argument{.name = "CAMPAIGN",
             .help =
                 "Folder of a campaign, its points table campaign.nxs, or a recording; several are fitted "
                 "together",
             .kind = Kind::file,
             .many = true},
    manual::quantity_option("--gravity", "ACCELERATION", Dimension::acceleration, {0.1, 100},
                            "Gravity at the place, e.g. 9.83m/s^2", {},
                            "that of the bench: gravity_mps2 in its rig file, or 9.8 m/s^2"),
    Argument{.name = "--level", .help = "Take the base as level also where mirror partners show its tilt"},
    manual::json_argument};

using TextOf = std::string (*)(const std::vector<std::filesystem::path>&, const MuOptions&, bool);

int act_with(TextOf text_of, const manual::Values& values) {
    std::vector<std::filesystem::path> files;
    for (const std::string& name : values.texts("CAMPAIGN")) files.push_back(points_file(name));
    return confined(files.front().string(), confinement_for_points(files), [&] {
        report::say(text_of(files,
                            {.gravity = values.has("--gravity") ? values.number("--gravity") : NAN,
                             .free_tilt = !values.has("--level")},
                            values.has("--json")));
        return manual::exit_ok;
    });
}

/// The recordings whose measurements are points already.
class Given {
public:
    /// InputError when it was given before, alone or in a campaign.
    void add(const std::filesystem::path& file) {
        if (!files_.insert(std::filesystem::weakly_canonical(file)).second)
            throw InputError{fmt::format(
                "{}: its measurements are given twice, by its name or in a campaign; give each of them once",
                file.string())};
    }
    void add(const std::filesystem::path& table, const campaign::PointsTable& points) {
        add(table);
        std::set<std::string> names;
        for (const campaign::PointPass& pass : points.passes) names.insert(pass.recording);
        for (const std::string& name : names)
            if (!name.empty()) add(table.parent_path() / (name + ".nxs"));
    }

private:
    std::set<std::filesystem::path> files_;
};

// Recordings stand together as one more campaign.
law::Findings findings_of(const std::vector<std::filesystem::path>& paths, const MuOptions& options) {
    std::vector<law::Point> points, runs;
    int campaigns = 0;
    double place = NAN;  // gravity of those so far
    Given given;
    for (const std::filesystem::path& path : paths) {
        const std::filesystem::path file = points_file(path);
        double gravity = NAN;
        if (campaign::has_points(file)) {
            const campaign::PointsTable table = campaign::read_points(file);
            gravity = table.gravity;
            given.add(file, table);
            std::vector<law::Point> own = campaign::law_points(table, campaigns++);
            if (own.empty())
                throw InputError{fmt::format("{}: the campaign has no measured point", path.string())};
            points.insert(points.end(), std::make_move_iterator(own.begin()),
                          std::make_move_iterator(own.end()));
        } else {
            given.add(file);
            gravity = campaign::add_recording(file, runs);
        }
        if (std::isnan(options.gravity) && std::isfinite(place) && gravity != place)
            throw InputError{fmt::format(
                "{}: gravity is {} m/s^2, {} m/s^2 in the one before; fit them apart, or give --gravity",
                path.string(), gravity, place)};
        place = gravity;
    }
    for (law::Point& p : runs) p.campaign = campaigns;
    points.insert(points.end(), std::make_move_iterator(runs.begin()), std::make_move_iterator(runs.end()));
    return law::analyse(std::move(points), {.g = std::isnan(options.gravity) ? place : options.gravity,
                                            .free_tilt = options.free_tilt});
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
    law::Findings findings = findings_of(campaigns, options);
    if (findings.coulomb.mu.refused) findings.verdict = judge(findings, options.free_tilt);
    return json ? findings_json(findings) : findings_text(findings);
}

std::string law_text(const std::vector<std::filesystem::path>& campaigns, const MuOptions& options,
                     bool json) {
    const law::Findings findings = findings_of(campaigns, options);
    const law::Verdict verdict = judge(findings, options.free_tilt);
    if (json) {
        nlohmann::ordered_json j = verdict_json(verdict);
        j["friction"] = friction_json(findings.friction);
        j["friction_tilt"] = friction_tilt_json(findings.friction);
        return j.dump(2) + "\n";
    }
    const std::string friction = friction_text(findings.friction);
    return friction + (friction.empty() ? "" : "\n") + verdict_text(verdict);
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
        .summary = "Fit the friction coefficient to campaigns and recordings",
        .details =
            "mu_ac: exact Coulomb law at the measured drives, with tilt and the walker's push on the base. "
            "mu_k: slopes of v(t) in slips. mu_ns: the paper's no-stick formula, 13 to 23 % too low. Budgets "
            "list the sources of uncertainty, largest first; those marked as estimates are defaults.",
        .arguments = mu_arguments,
        .example = "shakerd mu paper",
        .exit_statuses = {manual::exit_device},
        .act = [](const manual::Values& values) { return act_with(mu_text, values); }};
}

manual::Command law_row() {
    return {
        .name = "law",
        .summary = "Judge which law of friction describes campaigns or recordings",
        .details =
            "First friction against the velocity of slip, free of any law. Then each law is fitted to v_D of "
            "all points at their measured drives, and to harmonics 9 to 16 of the base, which the walker's "
            "friction moves. The laws are judged by Schwarz's criterion, chi^2 + k "
            "ln n. The last line names the law that describes the points, with its parameters; the laws that "
            "these points do not distinguish from it, and a drive that would; or that no law of the list "
            "describes them.",
        .arguments = mu_arguments,
        .example = "shakerd law paper",
        .exit_statuses = {manual::exit_device},
        .act = [](const manual::Values& values) { return act_with(law_text, values); }};
}

}  // namespace shaker::commands
