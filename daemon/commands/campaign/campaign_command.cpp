#include "daemon/commands/campaign/campaign_command.hpp"

#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <numbers>
#include <optional>
#include <utility>

#include "daemon/campaign/campaign.hpp"
#include "daemon/campaign/campaign_folder.hpp"
#include "daemon/campaign/plan_check.hpp"
#include "daemon/campaign/plan_file.hpp"
#include "daemon/campaign/point_results.hpp"
#include "daemon/campaign/schedule.hpp"
#include "daemon/commands/campaign/operator_lines.hpp"
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

std::string place(const campaign::Point& p) {
    return fmt::format("{} {:.4g} Hz gamma {:.4g} m/s^2 rho {:.3g} phi {:.1f} deg", p.series,
                       p.asked.drive.frequency, p.asked.drive.gamma, p.asked.drive.rho,
                       p.asked.drive.phi * 180 / std::numbers::pi);
}

/// One line for each event that an operator wants to see.
class Progress {
public:
    Progress(const campaign::Engine& engine, const std::vector<campaign::Point>& points)
        : engine_{engine}, points_{points} {}

    /// At once, also into a pipe: campaigns last for hours.
    void print(const campaign::Event& event, double now_s) const {
        if (const auto* ended = std::get_if<campaign::PointEnded>(&event)) {
            const campaign::Point& p = points_[static_cast<std::size_t>(ended->point - 1)];
            const auto v_D = engine_.result(ended->point);
            const std::string result =
                ended->outcome == campaign::Outcome::measured
                    ? fmt::format("v_D {:+.4f} +- {:.4f} mm/s", 1e3 * v_D.value, 1e3 * v_D.sigma)
                    : fmt::format("{}: {}", campaign::outcome_words[static_cast<std::size_t>(ended->outcome)],
                                  ended->reason);
            report::say(fmt::format("{:7.1f} s  point {} of {}  {}  {}\n", now_s, ended->point,
                                    points_.size(), place(p), result));
        } else if (const auto* change = std::get_if<campaign::CampaignChange>(&event)) {
            report::say(fmt::format("{:7.1f} s  {}: {}\n", now_s,
                                    campaign::CampaignChange::words[static_cast<std::size_t>(change->what)],
                                    change->reason));
        }
        std::fflush(stdout);
    }

private:
    const campaign::Engine& engine_;
    const std::vector<campaign::Point>& points_;
};

std::vector<int> ended_points(const std::vector<campaign::Point>& points,
                              const campaign::Progress& progress) {
    std::vector<int> ended;
    for (const campaign::Point& p : points)
        if (progress.done(p.id)) ended.push_back(p.id);
    return ended;
}

int recordings_in(const std::filesystem::path& folder) {
    int newest = 0;
    for (const auto& entry : std::filesystem::directory_iterator{folder}) {
        const std::string name = entry.path().filename().string();
        if (name.starts_with('r')) newest = std::max(newest, std::atoi(name.c_str() + 1));
    }
    return newest;
}

/// InputError for a recording that was not completed: its measurements are lost unless it is recovered.
void require_complete(const std::filesystem::path& folder) {
    for (const auto& entry : std::filesystem::directory_iterator{folder})
        if (entry.path().string().ends_with(".nxs.part"))
            throw InputError{
                fmt::format("{0}: this recording was interrupted; complete it first: \"shakerd recover {0}\"",
                            entry.path().string())};
}

/// What the folder has, after its recordings were looked at: a pass that they do not have must be measured
/// again.
campaign::Progress progress_of(campaign::CampaignFolder& folder, const std::vector<campaign::Point>& points) {
    const campaign::Progress& stored = folder.stored().progress;
    for (const campaign::PassLost& lost :
         campaign::point_results(folder.path(), asked_rows(points), stored, campaign::Source::stored).lost)
        folder.add(lost);
    return campaign::read_campaign(folder.path()).progress;
}

void obey(campaign::Campaign& campaign, const std::string& line, acquisition::Channels& channels) try {
    campaign.obey(line, channels);
} catch (const InputError& e) {
    report::say(std::string{e.what()} + "\n");
}

void print_summary(const campaign::PointsTable& table, double bench_s, double wall_s,
                   const std::filesystem::path& file) {
    std::size_t measured = 0, with_truth = 0, far = 0;
    double squares = 0;
    for (const campaign::PointRow& row : table.points) {
        if (row.outcome != "measured") continue;
        ++measured;
        if (!std::isfinite(row.true_v_D)) continue;
        const double z = (row.v_D.value - row.true_v_D) / row.v_D.sigma;
        ++with_truth;
        squares += z * z;
        if (std::abs(z) > 3) ++far;
    }
    report::say(fmt::format("{} of {} points measured; {:.0f} s of bench time in {:.0f} s\n", measured,
                            table.points.size(), bench_s, wall_s));
    if (with_truth > 0)
        report::say(fmt::format(
            "measured minus simulated truth: {:.2f} standard errors rms; {} of {} points beyond 3\n",
            std::sqrt(squares / static_cast<double>(with_truth)), far, with_truth));
    report::say(fmt::format("points table: {}\n", file.string()));
}

}  // namespace

void check_plan(const CampaignOptions& options) {
    const campaign::Plan plan = campaign::read_plan(options.plan);
    const std::vector<campaign::Point> points = campaign::schedule(plan);
    const run::RunnerSettings settings = runner_settings(options, points);
    const bench::Bench bench = bench::open_bench(settings.run.rig, settings.run.scene,
                                                 simulated::World::Pace::lockstep, settings.run.standard);
    require_possible(plan, points, bench);
    const View& view = bench.rig.cameras.front()->view();
    double walker_mm = 0;
    for (const Target& t : view.targets)
        if (t.name == "walker") walker_mm = std::max(t.diameter_mm, t.width_mm);
    if (!bench.world && !std::isfinite(options.view_m))
        throw InputError{
            "--view is missing: the length of the view is not known before a camera of real devices sends "
            "pictures"};
    const double view_m = std::isfinite(options.view_m)
                              ? options.view_m
                              : 1e-3 * view.mm_per_px * bench.scene.cameras.front().width;
    const campaign::PlanCheck check = campaign::check_plan(
        plan, {.way = {.view = view_m, .walker = 1e-3 * walker_mm, .edge = 1e-3 * bench.limits.edge_mm},
               .gravity = bench.gravity});
    report::say(options.json ? campaign::check_json(check) + "\n" : campaign::check_text(check));
}

void measure_campaign(const CampaignOptions& options) {
    const bool continues = options.plan.empty();
    const std::filesystem::path file = continues ? options.folder / campaign::plan_name : options.plan;
    const std::string plan_text = text_of(file);
    const campaign::Plan plan = campaign::parse_plan(plan_text, file.string());
    const std::vector<campaign::Point> points = campaign::schedule(plan);
    if (continues)
        require_complete(options.folder);
    else
        campaign::prepare_folder(options.folder);
    run::Runner runner{runner_settings(options, points)};
    for (const std::string& granted : runner.bench().granted) spdlog::info("{}", granted);
    require_possible(plan, points, runner.bench());
    auto folder = continues ? campaign::CampaignFolder::continued(options.folder)
                            : campaign::CampaignFolder::begin(options.folder, plan_text);
    if (!folder.stored().remark.empty()) spdlog::warn("{}", folder.stored().remark);
    const bool live = !runner.bench().world || options.run.threads;
    campaign::Engine engine{points,
                            {.mu = plan.mu, .g = runner.bench().gravity},
                            ended_points(points, progress_of(folder, points))};
    const Progress progress{engine, points};
    campaign::Campaign campaign{runner,
                                engine,
                                {.run = options.run,
                                 .folder = options.folder,
                                 .recordings = recordings_in(options.folder),
                                 .beside = live},
                                [&](const campaign::Event& event, double now_s) {
                                    folder.add(event);
                                    progress.print(event, now_s);
                                }};
    const StopSignals signals{runner};
    OperatorLines lines;
    bool nobody = false;
    int stops = 0;  // requests that were obeyed
    runner.lead(
        [&](const acquisition::Streams& streams, acquisition::Channels& channels) {
            runner.require_real_time();
            const bool any = campaign.step(streams, channels);
            // A bench on virtual time waits in a pause for the operator; a real one goes on playing silence.
            const bool waits = engine.paused() && campaign.on_call().at_rest() && !live;
            while (const auto line = lines.next(waits)) obey(campaign, *line, channels);
            nobody = engine.paused() && campaign.on_call().at_rest() && lines.closed();
            if (const int asked = runner.stop_requests(); asked > std::exchange(stops, asked)) {
                if (asked > 1) ++channels.aborts;
                engine.leave();
            }
            return any;
        },
        [&] { return campaign.done() || nobody; });
    folder.add(campaign::CampaignChange{.what = nobody || runner.stop_requests() > 0
                                                    ? campaign::CampaignChange::What::paused
                                                    : campaign::CampaignChange::What::ended,
                                        .reason = nobody ? "nobody is there to resume it" : ""});
    const campaign::PointResults results =
        campaign::point_results(options.folder, asked_rows(points),
                                campaign::read_campaign(options.folder).progress, campaign::Source::stored);
    for (const std::string& remark : results.remarks) spdlog::info("{}", remark);
    const std::filesystem::path table = options.folder / campaign::table_name;
    campaign::write_points(table, plan.title, plan_text, results.table);
    print_summary(results.table, runner.played_s(), runner.wall_s(), table);
    StopSignals::rethrow();
    if (nobody)
        throw TripError{
            fmt::format("the campaign is paused; clear the cause, then \"shakerd campaign {} --continue\"",
                        options.folder.string())};
}

bool reduce_campaign(const std::filesystem::path& folder) {
    const campaign::StoredCampaign stored = campaign::read_campaign(folder);
    const std::string name = (folder / campaign::plan_name).string();
    const campaign::Plan plan = campaign::parse_plan(stored.plan, name);
    const std::vector<campaign::PointRow> asked = asked_rows(campaign::schedule(plan));
    const campaign::PointResults now =
        campaign::point_results(folder, asked, stored.progress, campaign::Source::raw);
    for (const std::string& remark : now.remarks) report::say(remark + "\n");
    const std::filesystem::path file = folder / campaign::table_name;
    if (!std::filesystem::exists(file)) {
        campaign::write_points(file, plan.title, stored.plan, now.table);
        report::say(fmt::format("points table: {}\n", file.string()));
        return true;
    }
    const std::vector<std::string> differences =
        campaign::differences(campaign::read_points(file), now.table);
    for (const std::string& difference : differences) report::say(difference + "\n");
    if (differences.empty())
        report::say(fmt::format("reduce: identical ({} points, to the bit)\n", now.table.points.size()));
    return differences.empty();
}

}  // namespace shaker::commands
