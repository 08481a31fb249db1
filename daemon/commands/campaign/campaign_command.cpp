#include "daemon/commands/campaign/campaign_command.hpp"

#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <utility>

#include "daemon/campaign/campaign_folder.hpp"
#include "daemon/campaign/lead/plan_on_bench.hpp"
#include "daemon/campaign/lead/session.hpp"
#include "daemon/campaign/plan.hpp"
#include "daemon/campaign/plan_check.hpp"
#include "daemon/campaign/plan_file.hpp"
#include "daemon/campaign/point_results.hpp"
#include "daemon/commands/campaign/campaign_lines.hpp"
#include "daemon/commands/campaign/operator_input.hpp"
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

/// The check of a plan on this bench. view_m: NaN on a real bench whose view is not known.
campaign::PlanCheck checked(const campaign::Plan& plan, const bench::Bench& bench, double view_m) {
    campaign::CheckSettings settings = campaign::check_settings(plan, campaign::schedule(plan), bench);
    settings.way.view = view_m;
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

/// Bench time of each point, s; the view of a real bench without --view counts as wide.
std::vector<double> predicted_s(const campaign::Plan& plan, const bench::Bench& bench,
                                const CampaignOptions& options) {
    const double view_m = view_of(options, bench);
    std::vector<double> bench_s;
    for (const campaign::CheckedPoint& p : checked(plan, bench, std::isfinite(view_m) ? view_m : 1).points)
        bench_s.push_back(p.stage.bench_s());
    return bench_s;
}

/// The command leads a bench whose runner it owns.
class Lead {
public:
    Lead(run::Runner& runner, const campaign::SessionSettings& settings, const CampaignOptions& options)
        : runner_{runner},
          live_{settings.beside},
          run_{settings.run},
          on_call_{runner, live_},
          session_{runner, on_call_, settings,
                   [this](const campaign::Event& event, double now_s) { lines_.event(event, now_s); }},
          lines_{session_.engine(), session_.points(),
                 predicted_s(session_.plan(), runner.bench(), options)} {}

    /// Leads the bench through the points that are left, and writes their table.
    void run() {
        const StopSignals signals{runner_};
        OperatorInput input{keys};
        if (input.keys()) lines_.say(keys_help);
        runner_.lead([&](const acquisition::Streams& streams,
                         acquisition::Channels& channels) { return step(streams, channels, input); },
                     [&] { return session_.campaign().done() || nobody_; });
        using What = campaign::CampaignChange::What;
        const campaign::PointsTable table = session_.finish(
            {.what = nobody_ || runner_.stop_requests() > 0 ? What::paused : What::ended,
             .reason = nobody_ ? "nobody is there to resume it" : session_.engine().known_mu()});
        if (session_.plan().mu_target > 0) lines_.say(session_.engine().known_mu());
        lines_.say(campaign_summary(table, session_.campaign().time(), session_.returns(), runner_.wall_s()) +
                   fmt::format("points table: {}", (session_.folder() / campaign::table_name).string()));
    }
    /// It is paused, and standard input has ended.
    [[nodiscard]] bool nobody() const noexcept { return nobody_; }

private:
    bool step(const acquisition::Streams& streams, acquisition::Channels& channels, OperatorInput& input) {
        runner_.require_real_time();
        campaign::Campaign& campaign = session_.campaign();
        const bool any = on_call_.take(streams, channels);
        while (const auto measured = on_call_.measured()) campaign.take(*measured);
        session_.order(channels);
        on_call_.follow(run_, channels);
        while (const auto run = on_call_.finished()) campaign.take(*run);
        campaign.follow();
        lines_.status(campaign.time().sum() - campaign.time().checking);
        // A bench on virtual time waits in a pause for the operator; a real one goes on playing silence. What
        // a word has begun goes on before the next one is read.
        const bool waits = campaign.waits_for_a_person();
        if (const auto word = input.next(waits && !live_)) obey(campaign, *word, channels, lines_);
        nobody_ = input.closed() && campaign.waits_for_a_person();
        if (const int asked = runner_.stop_requests(); asked > std::exchange(stops_, asked)) {
            if (asked > 1) ++channels.aborts;
            session_.engine().leave();
        }
        return any;
    }

    run::Runner& runner_;
    bool live_, nobody_ = false;
    run::RunOptions run_;
    on_call::OnCall on_call_;
    campaign::Session session_;
    CampaignLines lines_;
    int stops_ = 0;  // requests that were obeyed
};

}  // namespace

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
    Lead lead{runner,
              {.folder = options.folder,
               .plan = plan_text,
               .plan_file = file.string(),
               .continues = continues,
               .run = settings.run,
               .beside = !runner.bench().world || settings.run.threads},
              options};
    lead.run();
    StopSignals::rethrow();
    if (lead.nobody())
        throw TripError{
            fmt::format("the campaign is paused; clear the cause, then \"shakerd campaign {} --continue\"",
                        options.folder.string())};
}

bool reduce_campaign(const std::filesystem::path& folder, const std::filesystem::path& working) {
    const campaign::StoredCampaign stored = campaign::read_campaign(folder);
    const std::string name = (folder / campaign::plan_name).string();
    const campaign::Plan plan = campaign::parse_plan(stored.plan, name);
    const std::vector<campaign::PointRow> asked = campaign::asked_rows(campaign::schedule(plan));
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
