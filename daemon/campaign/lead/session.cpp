#include "daemon/campaign/lead/session.hpp"

#include <spdlog/fmt/fmt.h>
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

// A view that is not known counts as wide.
std::vector<double> predicted_s(const Plan& plan, const std::vector<Point>& points, const bench::Bench& bench,
                                double longest_recording_s, double view_m) {
    CheckSettings settings = check_settings(plan, points, bench);
    settings.timing.recording_s = longest_recording_s;
    settings.way.view = std::isfinite(view_m) ? view_m : 1;
    std::vector<double> bench_s;
    for (const CheckedPoint& p : check_plan(plan, points, settings).points)
        bench_s.push_back(p.stage.bench_s());
    return bench_s;
}

std::string return_sentence(const std::vector<Returned>& returns) {
    std::vector<double> errors_mm;
    errors_mm.reserve(returns.size());
    for (const Returned& r : returns) errors_mm.push_back(1e3 * std::abs(r.x_to_m - r.x_asked_m));
    std::ranges::sort(errors_mm);
    return fmt::format(
        "{} returns; the walker turned {:.2f} mm from its target at the median, {:.2f} mm at most",
        errors_mm.size(), errors_mm[errors_mm.size() / 2], errors_mm.back());
}

std::string truth_sentence(const PointsTable& table) {
    std::size_t with_truth = 0, far = 0;
    double squares = 0, worst = 0;
    int worst_point = 0;
    for (const PointRow& row : table.points) {
        if (row.outcome != outcome_words[0] || !std::isfinite(row.true_v_D)) continue;
        const double z = (row.v_D.value - row.true_v_D) / row.v_D.sigma;
        ++with_truth;
        squares += z * z;
        if (std::abs(z) > 3) ++far;
        if (std::abs(z) > std::abs(worst)) worst = z, worst_point = row.point;
    }
    if (with_truth == 0) return {};
    return fmt::format(
        "measured minus simulated truth: {:.2f} standard errors rms; {} of {} points beyond 3; "
        "the farthest is point {} with {:+.2f}",
        std::sqrt(squares / static_cast<double>(with_truth)), far, with_truth, worst_point, worst);
}

}  // namespace

void require_possible(const Plan& plan, const std::vector<Point>& points, const bench::Bench& bench) {
    for (const Point& p : points) {
        run::require_seen(bench, p.asked.drive);
        run::require_pictures(bench.rig, p.asked.drive.frequency);
    }
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
    std::vector<double> bench_s = predicted_s(plan, points, bench, longest_recording_s, settings.view_m);
    return {settings,          std::move(text),   std::move(plan), std::move(points),
            std::move(folder), std::move(engine), recordings,      std::move(bench_s)};
}

Session::Session(run::Runner& runner, on_call::OnCall& on_call, PreparedSession prepared,
                 const Campaign::Listener& listener)
    : plan_text_{std::move(prepared.plan_text)},
      plan_{std::move(prepared.plan)},
      points_{std::move(prepared.points)},
      folder_{std::move(prepared.folder)},
      engine_{std::move(prepared.engine)},
      journal_{folder_, prepared.settings.beside},
      bench_s_{std::move(prepared.bench_s)},
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
                }} {
    for (std::size_t i = 0; i < bench_s_.size(); ++i)
        if (engine_.over()[i]) before_s_ += bench_s_[i];
}

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

std::vector<std::string> Session::summary(const PointsTable& table) const {
    const BenchTime& time = campaign_.time();
    std::vector<std::string> sentences{fmt::format(
        "{} of {} points measured; {:.0f} s of bench time: measuring {:.0f} s, settling {:.0f} s, returning "
        "{:.0f} s, starting and checking {:.0f} s",
        std::ranges::count(table.points, outcome_words[0], &PointRow::outcome), table.points.size(),
        time.sum(), time.measuring, time.settling, time.returning, time.checking)};
    if (!returns_.empty()) sentences.push_back(return_sentence(returns_));
    if (std::string truth = truth_sentence(table); !truth.empty()) sentences.push_back(std::move(truth));
    return sentences;
}

double Session::left_s() const {
    double left = 0, ended = -before_s_;
    for (std::size_t i = 0; i < bench_s_.size(); ++i) (engine_.over()[i] ? ended : left) += bench_s_[i];
    const double spent_s = campaign_.time().sum() - campaign_.time().checking;
    return ended > 0 ? left * spent_s / ended : left;
}

}  // namespace shaker::campaign
