#include "daemon/commands/campaign/campaign_command.hpp"

#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <utility>

#include "daemon/campaign/campaign.hpp"
#include "daemon/campaign/campaign_folder.hpp"
#include "daemon/campaign/plan.hpp"
#include "daemon/campaign/plan_check.hpp"
#include "daemon/campaign/plan_file.hpp"
#include "daemon/campaign/point_results.hpp"
#include "daemon/commands/campaign/campaign_lines.hpp"
#include "daemon/commands/campaign/journal_writer.hpp"
#include "daemon/commands/campaign/operator_input.hpp"
#include "daemon/commands/mu/law_points.hpp"
#include "daemon/commands/stop_signals.hpp"
#include "daemon/report/printing.hpp"
#include "daemon/run/run_setup.hpp"
#include "drivers/errors.hpp"

namespace shaker::commands {

namespace {

std::string text_of(const std::filesystem::path& file) {
    std::ifstream in{file};
    if (!in) throw InputError{fmt::format("{}: no such file; expected a plan (TOML)", file.string())};
    return {std::istreambuf_iterator<char>{in}, {}};
}

run::RunnerSettings runner_settings(const CampaignOptions& options,
                                    const std::vector<campaign::Point>& points) {
    run::RunnerSettings settings{
        .run = options.run, .on_call = true, .recordings = options.folder, .longest_recording_s = 7200};
    settings.run.drive = points.front().asked.drive;
    return settings;
}

/// InputError for a set-point beyond the limits of the bench.
void require_possible(const campaign::Plan& plan, const std::vector<campaign::Point>& points,
                      const bench::Bench& bench) {
    for (const campaign::Point& p : points) run::require_seen(bench, p.asked.drive.frequency);
    campaign::require_within_limits(plan, points, [&](const Drive& drive) {
        return run::run_demands(bench, drive, run::limits_of_run(bench.limits));
    });
}

std::vector<campaign::PointRow> asked_rows(const std::vector<campaign::Point>& points) {
    std::vector<campaign::PointRow> rows;
    for (const campaign::Point& p : points)
        rows.push_back({.point = p.id,
                        .series = p.series,
                        .repeat = p.repeat,
                        .partner = p.partner,
                        .asked = p.asked.drive});
    return rows;
}

int recordings_in(const std::filesystem::path& folder) {
    int newest = 0;
    for (const auto& entry : std::filesystem::directory_iterator{folder}) {
        const std::string name = entry.path().filename().string();
        if (name.starts_with('r')) newest = std::max(newest, std::atoi(name.c_str() + 1));
    }
    return newest;
}

struct Ended {
    std::vector<int> points;
    std::vector<law::Point> measured;
};

/// What the folder has, after its recordings were looked at: a pass that they do not have must be measured
/// again.
Ended ended_in(campaign::CampaignFolder& folder, const std::vector<campaign::Point>& points) {
    const campaign::PointResults stored = campaign::point_results(
        folder.path(), asked_rows(points), folder.stored().progress, campaign::Source::stored);
    for (const campaign::PassLost& lost : stored.lost) folder.add(lost);
    Ended ended{.points = {}, .measured = law_points(stored.table)};
    const campaign::Progress progress = campaign::read_campaign(folder.path()).progress;
    for (const campaign::Point& p : points)
        if (progress.done(p.id)) ended.points.push_back(p.id);
    std::erase_if(ended.measured, [&](const law::Point& p) { return !progress.done(p.number); });
    return ended;
}

void obey(campaign::Campaign& campaign, const std::string& word, acquisition::Channels& channels,
          CampaignLines& lines) try {
    campaign.obey(word, channels);
} catch (const InputError& e) {
    lines.say(e.what());
}

const Keys keys{{'p', "pause"}, {'r', "resume"}, {'s', "skip"}, {'m', "repeat"},
                {'e', "stop"},  {'a', "abort"},  {'c', "clear"}};
constexpr const char* keys_help =
    "keys: p pause, r resume, s skip this point, m measure the last point again, e end after this point, "
    "a abort, c clear a trip";

double walker_m(const View& view) {
    double mm = 0;
    for (const Target& t : view.targets)
        if (t.name == "walker") mm = std::max(t.diameter_mm, t.width_mm);
    return 1e-3 * mm;
}

/// The check of a plan on this bench. view_m: NaN on a real bench whose view is not known.
campaign::PlanCheck checked(const campaign::Plan& plan, const bench::Bench& bench, double view_m) {
    campaign::CheckSettings settings{
        .way = {.view = view_m,
                .walker = walker_m(bench.rig.cameras.front()->view()),
                .edge = 1e-3 * bench.limits.edge_mm,
                .margin = 1e-3 * plan.edge_margin_mm},
        .gravity = bench.gravity,
        .swing = [&bench](const Drive& drive) {
            const auto demands = run::run_demands(bench, drive, bench.limits);
            return 1e-3 * std::ranges::find(demands, "displacement", &safety::Demand::quantity)->value;
        }};
    if (bench.world) settings.start = 1e-3 * bench.scene.walker.start_mm;
    return campaign::check_plan(plan, settings);
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

/// Writes the points table of a folder as its recordings are now.
campaign::PointsTable write_table(const std::filesystem::path& folder, const campaign::Plan& plan,
                                  const std::string& plan_text,
                                  const std::vector<campaign::PointRow>& asked) {
    campaign::PointResults results = campaign::point_results(
        folder, asked, campaign::read_campaign(folder).progress, campaign::Source::stored);
    for (const std::string& remark : results.remarks) spdlog::info("{}", remark);
    campaign::write_points(folder / campaign::table_name, plan.title, plan_text, results.table);
    return std::move(results.table);
}

/// Bench time of each point, s; the view of a real bench without --view counts as wide.
std::vector<double> predicted_s(const campaign::Plan& plan, const bench::Bench& bench,
                                const CampaignOptions& options) {
    const double view_m = view_of(options, bench);
    std::vector<double> bench_s;
    for (const campaign::CheckedPoint& p : checked(plan, bench, std::isfinite(view_m) ? view_m : 1).points)
        bench_s.push_back(p.stage.bench_s());
    return bench_s;
}

struct Led {
    campaign::BenchTime time;
    std::vector<campaign::Returned> returns;
    bool nobody = false;  // it is paused, and standard input has ended
};

/// Leads the bench through the points that are left.
Led lead(run::Runner& runner, campaign::Engine& engine, campaign::CampaignFolder& folder,
         const campaign::Plan& plan, const run::RunOptions& run, CampaignLines& lines) {
    Led led;
    const bool live = !runner.bench().world || run.threads;
    JournalWriter journal{folder, live};
    const auto listen = [&](const campaign::Event& event, double now_s) {
        journal.add(event);
        if (const auto* r = std::get_if<campaign::Returned>(&event)) led.returns.push_back(*r);
        lines.event(event, now_s);
    };
    const campaign::CampaignSettings settings{.run = run,
                                              .folder = folder.path(),
                                              .recordings = recordings_in(folder.path()),
                                              .edge_margin_mm = plan.edge_margin_mm,
                                              .beside = live};
    campaign::Campaign campaign{runner, engine, settings, listen};
    const StopSignals signals{runner};
    OperatorInput input{keys};
    if (input.keys()) lines.say(keys_help);
    int stops = 0;  // requests that were obeyed
    const auto step = [&](const acquisition::Streams& streams, acquisition::Channels& channels) {
        runner.require_real_time();
        const bool any = campaign.step(streams, channels);
        if (const std::string why = journal.failure(); !why.empty())
            engine.failed("the journal cannot be written: " + why + "; make room, then resume");
        lines.status(campaign.time().sum() - campaign.time().checking);
        // A bench on virtual time waits in a pause for the operator; a real one goes on playing silence. What
        // a word has begun goes on before the next one is read.
        const bool waits = campaign.waits_for_a_person();
        if (const auto word = input.next(waits && !live)) obey(campaign, *word, channels, lines);
        led.nobody = input.closed() && campaign.waits_for_a_person();
        if (const int asked = runner.stop_requests(); asked > std::exchange(stops, asked)) {
            if (asked > 1) ++channels.aborts;
            engine.leave();
        }
        return any;
    };
    runner.lead(step, [&] { return campaign.done() || led.nobody; });
    led.time = campaign.time();
    using What = campaign::CampaignChange::What;
    journal.add(campaign::CampaignChange{
        .what = led.nobody || runner.stop_requests() > 0 ? What::paused : What::ended,
        .reason = led.nobody ? "nobody is there to resume it" : engine.known_mu()});
    journal.finish();
    return led;
}

}  // namespace

void check_plan(const CampaignOptions& options) {
    const campaign::Plan plan = campaign::read_plan(options.plan);
    const std::vector<campaign::Point> points = campaign::schedule(plan);
    run::RunnerSettings settings = runner_settings(options, points);
    place_walker(settings.run, plan, points.front());
    const bench::Bench bench = bench::open_bench(settings.run.rig, settings.run.scene,
                                                 simulated::World::Pace::lockstep, settings.run.standard);
    require_possible(plan, points, bench);
    const double view_m = view_of(options, bench);
    if (!std::isfinite(view_m))
        throw InputError{
            "--view is missing: the length of the view is not known before a camera of real devices sends "
            "pictures"};
    const campaign::PlanCheck check = checked(plan, bench, view_m);
    report::say(options.json ? campaign::check_json(check) + "\n" : campaign::check_text(check));
}

void measure_campaign(const CampaignOptions& options) {
    const bool continues = options.plan.empty();
    const std::filesystem::path file = continues ? options.folder / campaign::plan_name : options.plan;
    const std::string plan_text = text_of(file);
    const campaign::Plan plan = campaign::parse_plan(plan_text, file.string());
    const std::vector<campaign::Point> points = campaign::schedule(plan);
    if (!continues) campaign::prepare_folder(options.folder);
    run::RunnerSettings settings = runner_settings(options, points);
    place_walker(settings.run, plan, points.front());
    run::Runner runner{settings};
    for (const std::string& granted : runner.bench().granted) spdlog::info("{}", granted);
    require_possible(plan, points, runner.bench());
    auto folder = continues ? campaign::CampaignFolder::continued(options.folder)
                            : campaign::CampaignFolder::begin(options.folder, plan_text);
    if (!folder.stored().remark.empty()) spdlog::warn("{}", folder.stored().remark);
    const Ended ended = ended_in(folder, points);
    campaign::Engine engine{points,
                            {.mu = plan.mu, .mu_target = plan.mu_target, .g = runner.bench().gravity},
                            ended.points,
                            ended.measured};
    CampaignLines lines{engine, points, predicted_s(plan, runner.bench(), options)};
    Led led = lead(runner, engine, folder, plan, settings.run, lines);
    const campaign::PointsTable table = write_table(options.folder, plan, plan_text, asked_rows(points));
    if (plan.mu_target > 0) lines.say(engine.known_mu());
    lines.say(campaign_summary(table, led.time, led.returns, runner.wall_s()) +
              fmt::format("points table: {}", (options.folder / campaign::table_name).string()));
    StopSignals::rethrow();
    if (led.nobody)
        throw TripError{
            fmt::format("the campaign is paused; clear the cause, then \"shakerd campaign {} --continue\"",
                        options.folder.string())};
}

bool reduce_campaign(const std::filesystem::path& folder, const std::filesystem::path& working) {
    const campaign::StoredCampaign stored = campaign::read_campaign(folder);
    const std::string name = (folder / campaign::plan_name).string();
    const campaign::Plan plan = campaign::parse_plan(stored.plan, name);
    const std::vector<campaign::PointRow> asked = asked_rows(campaign::schedule(plan));
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

}  // namespace shaker::commands
