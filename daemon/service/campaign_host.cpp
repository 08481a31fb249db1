#include "daemon/service/campaign_host.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <exception>
#include <utility>

#include "daemon/campaign/lead/campaign.hpp"
#include "daemon/campaign/lead/plans.hpp"
#include "daemon/campaign/plan.hpp"
#include "drivers/errors.hpp"

namespace shaker::service {

namespace {

using What = campaign::CampaignChange::What;

std::string not_written(const campaign::Session& session, const std::string& why) {
    return fmt::format(
        "the points table of {} could not be written: {}; \"shakerd campaign {} --reduce\" "
        "makes it from the recordings",
        session.folder().string(), why, session.folder().string());
}

std::string finish(campaign::Session& session, const campaign::CampaignChange& last) try {
    const campaign::PointsTable table = session.finish(last);
    const auto measured =
        std::ranges::count(table.points, campaign::outcome_words[0], &campaign::PointRow::outcome);
    return fmt::format("{}: {} of {} points measured; points table: {}", last.reason, measured,
                       table.points.size(), (session.folder() / campaign::table_name).string());
} catch (const std::exception& e) {
    return not_written(session, e.what());
}

PlanCheckState in_short(const std::string& name, const campaign::PlanCheck& check) {
    PlanCheckState s{.name = name,
                     .points = check.points.size(),
                     .fit = check.points.size() - check.failing,
                     .bench_s = check.bench_s(),
                     .bytes = check.bytes,
                     .summary = campaign::sums_text(check, "; ")};
    for (const campaign::CheckedPoint& c : check.points)
        if (!c.travel.fits() && s.misfits.size() < PlanCheckState::most_misfits)
            s.misfits.push_back(campaign::misfit_text(c));
    return s;
}

}  // namespace

void CampaignHost::check(const std::string& name, std::string text, const View& view) {
    if (checking_.valid())
        throw InputError{
            fmt::format("plan \"{}\" is being checked; give the order again in a moment", checked_->name)};
    if (text.empty()) text = campaign::plan_text(plans_, name);
    const campaign::Plan plan = campaign::parse_plan(text, name);
    const std::vector<campaign::Point> points = campaign::schedule(plan);
    campaign::require_possible(plan, points, runner_.bench());
    campaign::CheckSettings settings = campaign::check_settings(plan, points, runner_.bench());
    settings.timing.recording_s = runner_.recordings().most_s();
    settings.way.view = view.view_m;
    settings.start = view.place_m;
    if (std::isfinite(view.bytes_per_s)) settings.bytes_per_s = view.bytes_per_s;
    checked_ = PlanCheckState{.name = name, .under_way = true};
    checking_ = checker_.run([name, plan, points, settings](const std::stop_token& stop) {
        return in_short(name, campaign::check_plan(plan, points, settings, stop));
    });
    if (!beside_) take_check();
}

void CampaignHost::take_check() {
    checked_ = checking_.get();
    log_(fmt::format("plan {}: {}", checked_->name, checked_->summary));
}

void CampaignHost::require_none(const std::string& what) const {
    if (active())
        throw InputError{what + " while a campaign is measured; end the campaign first (campaign stop)"};
}

const std::vector<std::string>& CampaignHost::plans(double now_s) {
    constexpr double fresh_s = 5;
    if (on_call_.at_rest() && now_s >= known_s_ + fresh_s) {
        known_ = campaign::plans_in(plans_);
        known_s_ = now_s;
    }
    return known_;
}

void CampaignHost::begin(const std::string& name, std::string text, const run::RunOptions& run) {
    require_none("no other campaign can begin");
    if (finishing_.valid())
        throw InputError{"the table of the last campaign is being written; give the order again in a moment"};
    if (text.empty()) text = campaign::plan_text(plans_, name);
    run::Recordings& recordings = runner_.recordings();
    const std::filesystem::path folder =
        recordings.folder() / fmt::format("{}-{}", name, recordings.file_named({}).stem().string());
    session_ = std::make_shared<campaign::Session>(
        runner_, on_call_,
        campaign::SessionSettings{
            .folder = folder, .plan = std::move(text), .plan_file = name, .run = run, .beside = beside_},
        [this](const campaign::Event& event, double /*now_s*/) {
            const std::string words = campaign::text(event, session_->engine(), session_->points());
            if (words.empty()) return;
            state_.newest = words;
            log_(words);
        });
    leaving_ = false;
    state_ = {.name = name, .title = session_->plan().title, .folder = folder.filename().string()};
    log_(fmt::format("{} begins: {} points, folder {}", name, session_->points().size(), folder.string()));
}

void CampaignHost::obey(campaign::Word word) {
    if (!session_) throw InputError{"no campaign is measured; start one first"};
    campaign::Engine& engine = session_->engine();
    // A paused campaign ends where it is; its folder can be continued later.
    if (word == campaign::Word::stop && engine.paused()) return engine.leave();
    engine.obey(word);
}

void CampaignHost::take(const on_call::Measured& measured) {
    if (session_) session_->campaign().take(measured);
}

void CampaignHost::order(acquisition::Channels& channels) {
    if (session_) session_->order(channels);
}

void CampaignHost::take(const run::FinishedRun& run) {
    if (session_) session_->campaign().take(run);
}

void CampaignHost::follow(bool leaving) {
    if (is_ready(finishing_)) log_(finishing_.get());
    if (is_ready(checking_)) take_check();
    if (!session_) return;
    session_->campaign().follow();
    if (leaving && !std::exchange(leaving_, true)) session_->engine().leave();
    if (session_->campaign().done()) end(leaving);
}

void CampaignHost::end(bool leaving) {
    state_ = *state();
    state_.doing = "ended";
    const bool left_out = leaving || state_.paused;
    const campaign::CampaignChange last{.what = left_out ? What::paused : What::ended,
                                        .reason = leaving                   ? "the program ends"
                                                  : state_.paused           ? "ended by the operator"
                                                  : state_.known_mu.empty() ? "complete"
                                                                            : state_.known_mu};
    state_.paused = false;
    try {
        finishing_ = desk_.run([session = session_, last] { return finish(*session, last); });
    } catch (const DeviceError& e) {
        log_(not_written(*session_, e.what()));
    }
    session_.reset();
    if (!beside_) log_(finishing_.get());
}

std::optional<CampaignState> CampaignHost::state() {
    if (state_.name.empty()) return std::nullopt;
    CampaignState s = state_;
    s.active = active() || finishing_.valid();
    if (!session_) return s;
    const campaign::Engine& engine = session_->engine();
    s.points = session_->points().size();
    s.ended = engine.ended();
    s.doing = engine.doing();
    s.paused = engine.paused();
    s.known_mu = engine.known_mu();
    if (const campaign::Point* p = engine.point()) s.point = campaign::place(*p);
    const campaign::BenchTime& time = session_->campaign().time();
    if (s.ended > 0 && s.known_mu.empty())
        s.left_s = time.sum() / static_cast<double>(s.ended) * static_cast<double>(s.points - s.ended);
    return s;
}

}  // namespace shaker::service
