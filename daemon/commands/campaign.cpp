#include "daemon/commands/campaign.hpp"

#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <utility>

#include "daemon/campaign/campaign_folder.hpp"
#include "daemon/campaign/lead/plans.hpp"
#include "daemon/campaign/lead/session.hpp"
#include "daemon/campaign/plan_check.hpp"
#include "daemon/campaign/point_results.hpp"
#include "daemon/commands/operator_dialogue.hpp"
#include "daemon/commands/recover.hpp"
#include "daemon/commands/run.hpp"
#include "daemon/commands/table.hpp"
#include "daemon/manual/values.hpp"
#include "daemon/report/printing.hpp"
#include "daemon/run/run_setup.hpp"
#include "daemon/run/stop_signals.hpp"
#include "daemon/sandbox/confined.hpp"
#include "daemon/sandbox/new_files.hpp"
#include "daemon/service/bench_port.hpp"
#include "daemon/service/bench_service.hpp"
#include "drivers/errors.hpp"
#include "drivers/recorded/h5/file_lock.hpp"

namespace shaker::commands {

namespace {

using manual::Argument;
using manual::Kind;

constexpr std::array<std::string_view, 2> camera_details{"positions", "pixels"};

constexpr std::array campaign_arguments{
    Argument{.name = "PLAN",
             .help = "Plan of the campaign (TOML); with --continue or --reduce: the campaign's folder",
             .kind = Kind::file},
    manual::rig_argument,
    manual::scene_argument,
    Argument{
        .name = "--detail",
        .help =
            "Cameras of the simulated bench: positions of the targets, in a view of 640 px, or pictures of "
            "320 px, which take a hundred times as long",
        .kind = Kind::word,
        .words = camera_details,
        .standard = "positions"},
    Argument{.name = "--output",
             .letter = 'o',
             .value = "FOLDER",
             .help = "New folder for journal, recordings and the points table campaign.nxs",
             .kind = Kind::folder,
             .otherwise = "the plan's name without its ending"},
    Argument{.name = "--check",
             .help = "Print points, order, predicted travel, bench time and bytes; nothing moves"},
    manual::whole_option("--view", "MM", {10, 10000},
                         "With --check: length of the view along the shaker's axis in mm", {},
                         "that of the simulated bench"),
    Argument{.name = "--continue",
             .help = "Measure the points that an interrupted campaign has not measured"},
    Argument{.name = "--reduce",
             .help = "Make the points table again from the recordings and compare it with the stored one"},
    frames_argument,
    Argument{.name = "--threads",
             .help = "Run each loop in its own thread, as on hardware, instead of in lockstep"},
    Argument{.name = "--real-time", .help = "With --threads: run a simulated rig in real time"},
    Argument{.name = "--json", .help = "With --check: print one JSON object; key names carry the SI units"}};

std::string plan_text_of(const std::filesystem::path& file) {
    std::ifstream in{file};
    if (!in) throw InputError{fmt::format("{}: no such file; expected a plan (TOML)", file.string())};
    return {std::istreambuf_iterator<char>{in}, {}};
}

constexpr double recording_s = 7200;  // longest recording

run::RunnerSettings runner_settings(const CampaignOptions& options,
                                    const std::vector<campaign::Point>& points) {
    run::RunnerSettings settings{.run = options.run,
                                 .on_call = true,
                                 .recordings = options.folder,
                                 .longest_recording_s = recording_s};
    settings.run.drive = points.front().asked.drive;
    return settings;
}

/// Gives a word of the operator to the bench. The answer comes in a later step.
void obey(service::BenchPort& port, const std::string& word, CampaignLines& lines) {
    const auto answer = [&lines](const std::string& refused) {
        if (!refused.empty()) lines.say(refused);
    };
    const auto known = std::ranges::find(campaign::word_names, word);
    if (known != campaign::word_names.end())
        port.order({service::TellCampaign{static_cast<campaign::Word>(known - campaign::word_names.begin())},
                    answer});
    else if (word == "abort")
        port.abort("operator");
    else if (word == "clear")
        port.order({service::ClearTrip{}, answer});
    else
        lines.say(fmt::format("\"{}\": expected pause, resume, skip, repeat, stop, abort or clear", word));
}

const Keys keys{{'p', "pause"}, {'r', "resume"}, {'s', "skip"}, {'m', "repeat"},
                {'e', "stop"},  {'a', "abort"},  {'c', "clear"}};
constexpr const char* keys_help =
    "keys: p pause, r resume, s skip this point, m measure the last point again, e end after this point, "
    "a abort, c clear a trip";

/// The check of a plan on this bench. view_m: NaN on a real bench whose view is not known.
campaign::PlanCheck plan_check(const campaign::Plan& plan, const std::vector<campaign::Point>& points,
                               const bench::Bench& bench, double view_m) {
    campaign::CheckSettings settings = campaign::check_settings(plan, points, bench);
    settings.timing.recording_s = recording_s;
    settings.way.view = view_m;
    if (bench.world) settings.start = 1e-3 * bench.scene.walker.start_mm;
    return campaign::check_plan(plan, points, settings);
}

double view_of(const CampaignOptions& options, const bench::Bench& bench) {
    if (std::isfinite(options.view_m) || !bench.world) return options.view_m;
    return 1e-3 * bench.rig.cameras.front()->view().mm_per_px * bench.scene.cameras.front().width;
}

/// The walker of a simulated bench starts where the first drive wants it, unless the scene says where.
void place_walker(run::RunOptions& run, const campaign::Plan& plan, const campaign::Point& first) {
    simulated::Scene& scene = run.standard;
    const simulated::CameraTruth& top = scene.cameras.front();
    if (!top.view.positions) return;
    campaign::WalkPredictor walks{plan.mu, scene.gravity};
    const campaign::FreeWay way{.view = 1e-3 * top.view.mm_per_px * top.width,
                                .walker = 1e-3 * scene.walker.diameter_mm,
                                .margin = 1e-3 * plan.edge_margin_mm};
    const campaign::Travel travel =
        campaign::travel(first.asked, walks.at(first.asked.drive), {}, way.length());
    scene.walker.start_mm = 1e3 * campaign::best_start(travel);
}

/// Leads the bench through the points that are left, and writes their table. False when the campaign is
/// paused and nobody is there to resume it.
bool lead(run::Runner& runner, campaign::PreparedSession prepared, std::FILE* lines_to) {
    const bool live = prepared.settings.beside;
    service::BenchPort port;
    // The engine learns mu by itself.
    service::BenchService bench{runner, {.beside = live, .fits_mu = false}, port};
    bench.measure(std::move(prepared));
    const run::StopSignals signals{runner};
    OperatorInput input{keys};
    CampaignLines lines{port, lines_to};
    if (input.keys()) lines.say(keys_help);
    int stops = 0;  // requests that were obeyed
    bool nobody = false;
    runner.lead(
        [&](const acquisition::Streams& streams, acquisition::Channels& channels) {
            runner.require_real_time();
            const bool any = bench.step(streams, channels);
            lines.follow();
            const service::CampaignState campaign = port.state()->campaign.value();
            // A bench on virtual time waits in a pause for the operator; a real one goes on playing silence.
            // What a word has begun goes on before the next one is read.
            if (const auto word = input.next(campaign.waits && !live)) obey(port, *word, lines);
            nobody = nobody || (input.closed() && campaign.waits);
            const bool ends = !campaign.active || nobody;
            if (const int asked = std::max(runner.stop_requests(), ends ? 1 : 0); asked > stops)
                for (; stops < asked; ++stops) bench.leave();
            return any;
        },
        [&] { return bench.done(); });
    lines.say(fmt::format("the bench played {:.0f} s in {:.0f} s", runner.played_s(), runner.wall_s()));
    return !nobody;
}

}  // namespace

std::string go_on(const CampaignOptions& options) {
    std::string words = fmt::format("shakerd campaign {} --continue", options.folder.string());
    if (options.run.rig != "sim:") words += " --rig " + options.run.rig;
    if (!options.run.scene.empty()) words += " --scene " + options.run.scene.string();
    return words;
}

void check_plan(const CampaignOptions& options) {
    const campaign::Plan plan = campaign::read_plan(options.plan);
    const std::vector<campaign::Point> points = campaign::schedule(plan);
    run::RunnerSettings settings = runner_settings(options, points);
    place_walker(settings.run, plan, points.front());
    const bench::Bench bench = bench::open_bench(settings.run.rig, settings.run.scene,
                                                 simulated::World::Pace::lockstep, settings.run.standard);
    campaign::require_possible(plan, points, bench);
    const double view_m = view_of(options, bench);
    if (!std::isfinite(view_m))
        throw InputError{
            "--view is missing: the length of the view is not known before a camera of real devices sends "
            "pictures"};
    const campaign::PlanCheck check = plan_check(plan, points, bench, view_m);
    report::say(options.json ? campaign::check_json(check) + "\n" : campaign::check_text(check));
}

void measure_campaign(const CampaignOptions& options) {
    const bool continues = options.plan.empty();
    const std::filesystem::path file = continues ? options.folder / campaign::plan_name : options.plan;
    const std::string plan_text =
        options.plan_text.empty() ? plan_text_of(file) : std::string{options.plan_text};
    const campaign::Plan plan = campaign::parse_plan(plan_text, file.string());
    const std::vector<campaign::Point> points =
        campaign::schedule(plan, continues ? campaign::most_stored_points : campaign::most_points);
    if (!continues) campaign::prepare_folder(options.folder);
    run::RunnerSettings settings = runner_settings(options, points);
    place_walker(settings.run, plan, points.front());
    run::Runner runner{settings};
    for (const std::string& granted : runner.bench().granted) spdlog::info("{}", granted);
    runner.require_commissioned();
    const bool anybody = lead(runner,
                              campaign::prepare({.folder = options.folder,
                                                 .plan = plan_text,
                                                 .plan_file = file.string(),
                                                 .continues = continues,
                                                 .run = settings.run,
                                                 .beside = !runner.bench().world || settings.run.threads,
                                                 .view_m = view_of(options, runner.bench())},
                                                runner.bench(), runner.recordings().most_s()),
                              options.lines_to);
    run::StopSignals::rethrow();
    if (!anybody)
        throw TripError{fmt::format("the campaign is paused; clear the cause, then \"{}\"", go_on(options))};
}

bool reduce_campaign(const std::filesystem::path& folder, const std::filesystem::path& working) {
    const campaign::StoredCampaign stored = campaign::read_campaign(folder);
    const std::string name = (folder / campaign::plan_name).string();
    const campaign::Plan plan = campaign::parse_plan(stored.plan, name);
    const std::vector<campaign::PointRow> asked =
        campaign::asked_rows(campaign::schedule(plan, campaign::most_stored_points));
    const campaign::PointResults now =
        campaign::point_results(folder, asked, stored.progress, campaign::Source::raw);
    for (const std::string& remark : now.remarks) report::say(remark + "\n");
    if (!working.empty()) {
        campaign::write_points(working, plan.title, stored.plan, now.table);
        return true;
    }
    const std::vector<std::string> differences =
        campaign::differences(campaign::read_points(folder / campaign::table_name), now.table);
    for (const std::string& difference : differences) report::say(difference + "\n");
    if (differences.empty())
        report::say(fmt::format("reduce: identical ({} points, to the bit)\n", now.table.points.size()));
    return differences.empty();
}

namespace {

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
int reduce_campaign_confined(const std::filesystem::path& folder) {
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
            return reduce_campaign(folder, working) ? manual::exit_ok : manual::exit_not_identical;
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

int act_on_campaign(const manual::Values& values) {
    const std::filesystem::path plan = values.text("PLAN");
    if (values.has("--reduce")) return reduce_campaign_confined(plan);
    const bool continues = values.has("--continue");
    if (continues) {
        require_at_rest(plan);
        complete_recordings(plan);
    }
    CampaignOptions options{.plan = continues ? std::filesystem::path{} : plan,
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
    (values.has("--check") ? check_plan : measure_campaign)(options);
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
        .arguments = campaign_arguments,
        .example = "shakerd campaign fig3.toml --rig sim: -o fig3",
        .exit_statuses = {manual::exit_device, manual::exit_not_identical, manual::exit_tripped,
                          manual::exit_signal},
        .act = act_on_campaign};
}

}  // namespace shaker::commands
