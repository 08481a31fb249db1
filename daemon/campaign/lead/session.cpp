#include "daemon/campaign/lead/session.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <utility>

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
                 run::Runner& runner) {
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
             .g = runner.bench().gravity,
             .timing = {.recording_s = runner.recordings().most_s()}},
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

Session::Session(run::Runner& runner, on_call::OnCall& on_call, const SessionSettings& settings,
                 const Campaign::Listener& listener)
    : plan_text_{settings.continues ? text_in(settings.folder / plan_name) : settings.plan},
      plan_{parse_plan(plan_text_, settings.plan_file)},
      points_{possible_points(plan_, settings.continues, runner.bench())},
      folder_{opened(settings, plan_text_)},
      engine_{engine_of(folder_, plan_, points_, runner)},
      journal_{folder_, settings.beside},
      campaign_{runner,
                on_call,
                engine_,
                {.run = settings.run,
                 .folder = folder_.path(),
                 .recordings = recordings_in(folder_.path()),
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
