#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include "daemon/campaign/campaign_folder.hpp"
#include "daemon/command_line/confined_recovery.hpp"
#include "daemon/command_line/rows.hpp"
#include "daemon/commands/campaign/campaign_command.hpp"
#include "daemon/sandbox/confined.hpp"
#include "daemon/sandbox/new_files.hpp"
#include "drivers/errors.hpp"
#include "drivers/recorded/h5/file_lock.hpp"

namespace shaker::command_line {

namespace {

using manual::Argument;
using manual::Kind;

constexpr std::array<std::string_view, 2> detail_words{"positions", "pixels"};

constexpr std::array arguments{
    Argument{.name = "PLAN",
             .help = "Plan of the campaign (TOML); with --continue or --reduce: the campaign's folder",
             .kind = Kind::file},
    rig_argument,
    scene_argument,
    Argument{
        .name = "--detail",
        .help =
            "Cameras of the simulated bench: positions of the targets, in a view of 640 px, or pictures of "
            "320 px, which take a hundred times as long",
        .kind = Kind::word,
        .words = detail_words,
        .standard = "positions"},
    Argument{.name = "--output",
             .letter = 'o',
             .value = "FOLDER",
             .help = "New folder for journal, recordings and the points table campaign.nxs",
             .kind = Kind::folder,
             .otherwise = "the plan's name without its ending"},
    Argument{.name = "--check",
             .help = "Print points, order, predicted travel, bench time and bytes; nothing moves"},
    Argument{.name = "--view",
             .value = "MM",
             .help = "With --check: length of the view along the shaker's axis in mm",
             .kind = Kind::whole,
             .allowed = {10, 10000},
             .otherwise = "that of the simulated bench"},
    Argument{.name = "--continue",
             .help = "Measure the points that an interrupted campaign has not measured"},
    Argument{.name = "--reduce",
             .help = "Make the points table again from the recordings and compare it with the stored one"},
    frames_argument,
    Argument{.name = "--threads",
             .help = "Run each loop in its own thread, as on hardware, instead of in lockstep"},
    Argument{.name = "--real-time", .help = "With --threads: run a simulated rig in real time"},
    Argument{.name = "--json", .help = "With --check: print one JSON object; key names carry the SI units"}};

/// Completes the recordings that an interruption has left. One that has nothing to recover stays as it is:
/// the journal counts none of its measurements.
void complete_recordings(const std::filesystem::path& folder) {
    if (!std::filesystem::is_directory(folder)) return;  // refused later, with its reason
    for (const auto& entry : std::filesystem::directory_iterator{folder}) {
        const std::filesystem::path part = entry.path();
        if (!part.string().ends_with(".nxs.part") ||
            std::filesystem::exists(std::filesystem::path{part}.replace_extension()))
            continue;
        if (recover_confined({.file = part}) != manual::exit_ok)
            spdlog::warn("{}: cannot be recovered; its points are measured again", part.string());
    }
}

/// InputError while a process measures into the folder.
void require_at_rest(const std::filesystem::path& folder) {
    if (const auto process = h5::locked_by(folder / campaign::journal_name))
        throw InputError{fmt::format("{}: process {} measures into this folder; wait until it ends",
                                     folder.string(), *process)};
}

/// Needs what its largest recording does.
int reduce_confined(const std::filesystem::path& folder) {
    require_at_rest(folder);
    const std::filesystem::path table = folder / campaign::table_name;
    std::filesystem::path largest = table;
    std::uintmax_t most = 0;
    std::error_code none;
    for (const auto& entry : std::filesystem::directory_iterator{folder, none})
        if (entry.path().extension() == ".nxs" && entry.file_size() > most)
            most = entry.file_size(), largest = entry.path();
    sandbox::Confinement allowed = sandbox::confinement_for(largest);
    allowed.files = {.lists = {folder}, .reads = {folder}};
    const auto reduced = [&](const std::filesystem::path& working) {
        return sandbox::confined(folder.string(), allowed, [&] {
            return commands::reduce_campaign(folder, working) ? manual::exit_ok : manual::exit_not_identical;
        });
    };
    if (std::filesystem::exists(table) || !std::filesystem::exists(folder / campaign::plan_name))
        return reduced({});
    sandbox::NewRecording fresh{table};
    allowed.files.writes = {fresh.folder()};
    const int status = reduced(fresh.working());
    if (status == manual::exit_ok) fresh.keep();
    return status;
}

int act(const manual::Values& values) {
    const std::filesystem::path plan = values.text("PLAN");
    if (values.has("--reduce")) return reduce_confined(plan);
    const bool continues = values.has("--continue");
    if (continues) {
        require_at_rest(plan);
        complete_recordings(plan);
    }
    commands::CampaignOptions options{
        .plan = continues ? std::filesystem::path{} : plan,
        .folder = continues ? plan : std::filesystem::path{values.text("--output")},
        .run = {},
        .json = values.has("--json")};
    options.run.rig = values.text("--rig");
    options.run.scene = values.text("--scene");
    if (values.has("--view")) options.view_m = 1e-3 * values.whole("--view");
    if (options.folder.empty()) options.folder = plan.stem();
    const bool positions = values.text("--detail") == "positions";
    options.run.standard =
        simulated::paper_scene(positions ? simulated::Detail::positions : simulated::Detail::pixels);
    options.run.pictures =
        positions ? recorded::KeptPictures::off
                  : recorded::kept_pictures_named(values.text("--frames")).value_or(options.run.pictures);
    options.run.threads = values.has("--threads");
    options.run.real_time = values.has("--real-time");
    (values.has("--check") ? commands::check_plan : commands::measure_campaign)(options);
    return manual::exit_ok;
}

}  // namespace

manual::Command campaign_row() {
    return {
        .name = "campaign",
        .summary = "Measure many set-points by a plan, unattended",
        .details =
            "The walker is led from point to point and kept in view. A trip pauses the campaign: words on "
            "standard input are pause, resume, skip, repeat (the last point), stop (after this point), "
            "abort, clear; on a terminal they are keys.",
        .arguments = arguments,
        .example = "shakerd campaign fig3.toml --rig sim: -o fig3",
        .exit_statuses = {manual::exit_device, manual::exit_not_identical, manual::exit_tripped,
                          manual::exit_signal},
        .act = act};
}

}  // namespace shaker::command_line
