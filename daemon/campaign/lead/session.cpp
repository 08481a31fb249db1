#include "daemon/campaign/lead/session.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <utility>

#include "daemon/campaign/lead/plans.hpp"
#include "daemon/campaign/plan.hpp"
#include "daemon/campaign/plan_check.hpp"
#include "daemon/campaign/point_results.hpp"
#include "daemon/run/run_setup.hpp"
#include "drivers/errors.hpp"

namespace shaker::campaign {

namespace {

int recordings_in(const std::filesystem::path& folder) {
    int newest = 0;
    for (const auto& entry : std::filesystem::directory_iterator{folder}) {
        const std::string name = entry.path().filename().string();
        if (name.starts_with('r')) newest = std::max(newest, std::atoi(name.c_str() + 1));
    }
    return newest;
}

std::string text_in(const std::filesystem::path& file) {
    std::ifstream in{file};
    if (!in) throw InputError{file.string() + ": no such file; expected the plan of a campaign"};
    return {std::istreambuf_iterator<char>{in}, {}};
}

std::vector<Point> possible_points(const Plan& plan, bool continues, const bench::Bench& bench) {
    std::vector<Point> points = schedule(plan, continues ? most_stored_points : most_points);
    require_possible(plan, points, bench);
    return points;
}

CampaignFolder opened(const SessionSettings& settings, const std::string& plan) {
    CampaignFolder folder = settings.continues ? CampaignFolder::continued(settings.folder)
                                               : CampaignFolder::begin(settings.folder, plan);
    const StoredCampaign& stored = folder.stored();
    if (!stored.remark.empty()) spdlog::warn("{}", stored.remark);
    for (const std::string& remark : stored.progress.remarks) spdlog::warn("{}, {}", journal_name, remark);
    return folder;
}

/// An engine for what the folder does not have yet. A pass that its recordings do not have must be measured
/// again.
Engine engine_of(CampaignFolder& folder, const Plan& plan, const std::vector<Point>& points,
                 const bench::Bench& bench, double longest_recording_s) {
    const PointResults stored =
        point_results(folder.path(), asked_rows(points), folder.stored().progress, Source::stored);
    for (const PassLost& lost : stored.lost) folder.add(lost);
    const Progress progress = read_campaign(folder.path()).progress;
    std::vector<int> ended;
    for (const Point& p : points)
        if (progress.done(p.id)) ended.push_back(p.id);
    std::vector<law::Point> measured = law_points(stored.table);
    std::erase_if(measured, [&](const law::Point& p) { return !progress.done(p.number); });
    return {points,
            {.mu = plan.mu,
             .mu_target = plan.mu_target,
             .g = bench.gravity,
             .timing = {.recording_s = longest_recording_s,
                        .most_return_gamma = most_return_gamma(points, bench)}},
            ended,
            measured};
}

}  // namespace

void require_possible(const Plan& plan, const std::vector<Point>& points, const bench::Bench& bench) {
    for (const Point& p : points) run::require_seen(bench, p.asked.drive.frequency);
    require_within_limits(plan, points, [&](const Drive& drive) {
        return run::run_demands(bench, drive, run::limits_of_run(bench.limits));
    });
}

PreparedSession prepare(const SessionSettings& settings, const bench::Bench& bench,
                        double longest_recording_s) {
    std::string text = settings.continues ? text_in(settings.folder / plan_name) : settings.plan;
    Plan plan = parse_plan(text, settings.plan_file);
    std::vector<Point> points = possible_points(plan, settings.continues, bench);
    CampaignFolder folder = opened(settings, text);
    Engine engine = engine_of(folder, plan, points, bench, longest_recording_s);
    const int recordings = recordings_in(folder.path());
    return {settings,          std::move(text),   std::move(plan), std::move(points),
            std::move(folder), std::move(engine), recordings};
}

Session::Session(run::Runner& runner, on_call::OnCall& on_call, PreparedSession prepared,
                 const Campaign::Listener& listener)
    : plan_text_{std::move(prepared.plan_text)},
      plan_{std::move(prepared.plan)},
      points_{std::move(prepared.points)},
      folder_{std::move(prepared.folder)},
      engine_{std::move(prepared.engine)},
      journal_{folder_, prepared.settings.beside},
      campaign_{runner,
                on_call,
                engine_,
                {.run = prepared.settings.run,
                 .folder = folder_.path(),
                 .recordings = prepared.recordings,
                 .edge_margin_mm = plan_.edge_margin_mm},
                [this, listener](const Event& event, double now_s) {
                    journal_.add(event);
                    if (const auto* r = std::get_if<Returned>(&event)) returns_.push_back(*r);
                    listener(event, now_s);
                }} {}

void Session::order(acquisition::Channels& channels) {
    campaign_.order(channels);
    if (const std::string why = journal_.failure(); !why.empty())
        engine_.failed("the journal cannot be written: " + why + "; make room, then resume");
}

PointsTable Session::finish(CampaignChange last) {
    journal_.add(std::move(last));
    journal_.finish();
    PointResults results = point_results(folder_.path(), asked_rows(points_),
                                         read_campaign(folder_.path()).progress, Source::stored);
    for (const std::string& remark : results.remarks) spdlog::info("{}", remark);
    write_points(folder_.path() / table_name, plan_.title, plan_text_, results.table);
    return std::move(results.table);
}

}  // namespace shaker::campaign
