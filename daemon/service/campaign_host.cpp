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

std::vector<std::string> finish(campaign::Session& session, const campaign::CampaignChange& last) try {
    std::vector<std::string> sentences = session.summary(session.finish(last));
    sentences.front() = last.reason + ": " + sentences.front();
    sentences.push_back("points table: " + (session.folder() / campaign::table_name).string());
    return sentences;
} catch (const std::exception& e) {
    return {not_written(session, e.what())};
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

void CampaignHost::check(const std::string& name, const std::string& text, const View& view) {
    if (checking_.valid())
        throw InputError{
            fmt::format("plan \"{}\" is being checked; give the order again in a moment", checked_->name)};
    auto is_read = std::make_shared<std::promise<void>>();
    reading_ = is_read->get_future();
    const bench::Bench& bench = runner_.bench();
    const double recording_s = runner_.recordings().most_s();
    checking_ = checker_.run([=, this, &bench](const std::stop_token& stop) {
        campaign::Plan plan;
        std::vector<campaign::Point> points;
        campaign::CheckSettings settings;
        try {
            plan = campaign::parse_plan(text.empty() ? campaign::plan_text(plans_, name) : text, name);
            points = campaign::schedule(plan);
            campaign::require_possible(plan, points, bench);
            settings = campaign::check_settings(plan, points, bench);
        } catch (...) {
            is_read->set_exception(std::current_exception());
            throw;
        }
        is_read->set_value();
        settings.timing.recording_s = recording_s;
        settings.way.view = view.view_m;
        settings.start = view.place_m;
        if (std::isfinite(view.bytes_per_s)) settings.bytes_per_s = view.bytes_per_s;
        return in_short(name, campaign::check_plan(plan, points, settings, stop));
    });
    checked_before_ = std::exchange(checked_, PlanCheckState{.name = name, .under_way = true});
}

bool CampaignHost::read() {
    if (!is_ready(reading_)) return false;
    try {
        reading_.get();
    } catch (...) {
        checking_ = {};
        checked_ = checked_before_;
        throw;
    }
    if (!beside_) take_check();
    return true;
}

void CampaignHost::take_check() {
    if (reading_.valid()) return;  // the order is answered first
    checked_ = checking_.get();
    log_(fmt::format("plan {}: {}", checked_->name, checked_->summary));
}

void CampaignHost::require_none(std::string_view what) const {
    if (active())
        throw InputError{
            fmt::format("{} while a campaign is measured; end the campaign first (campaign stop)", what)};
    if (prepares())
        throw InputError{fmt::format("{} while the folder of campaign {} is being made; wait, or stop it",
                                     what, preparing_name_)};
}

const std::vector<std::string>& CampaignHost::plans(double now_s) {
    constexpr double fresh_s = 5;
    if (on_call_.at_rest() && now_s >= known_s_ + fresh_s && !listing_.valid()) {
        const bool first = std::isinf(known_s_);
        listing_ = desk_.run([plans = plans_, first, recordings = runner_.recordings().folder()] {
            return Listed{campaign::plans_in(plans),
                          first ? campaign::newest_interrupted(recordings) : std::nullopt};
        });
        known_s_ = now_s;
    }
    if (is_ready(listing_)) take(listing_.get());
    return known_;
}

void CampaignHost::take(Listed&& listed) {
    known_ = std::move(listed.plans);
    if (!listed.interrupted || !state_.name.empty()) return;
    const campaign::InterruptedCampaign& found = *listed.interrupted;
    const std::string name = found.folder.filename().string();
    state_ = {
        .name = name,
        .title = found.title,
        .folder = name,
        .doing = "interrupted",
        .points = found.points,
        .ended = found.ended,
        .newest = fmt::format("campaign {} stopped before its end: {} of {} points have ended; when this "
                              "daemon has ended, \"shakerd campaign {} --continue\" measures the rest",
                              name, found.ended, found.points, found.folder.string())};
    log_(state_.newest);
}

void CampaignHost::prepare(const std::string& name, const std::string& text, const run::RunOptions& run,
                           double view_m) {
    if (finishing_.valid())
        throw InputError{"the table of the last campaign is being written; give the order again in a moment"};
    const bench::Bench& bench = runner_.bench();
    const double recording_s = runner_.recordings().most_s();
    preparing_ = desk_.run([=, this, &bench, folder = runner_.recordings().folder()] {
        const std::string stem = fmt::format("{}-{}", name, run::stem_now());
        std::filesystem::path own = folder / stem;
        for (int again = 2; std::filesystem::exists(own); ++again)  // two in one second
            own = folder / fmt::format("{}-{}", stem, again);
        return campaign::prepare({.folder = own,
                                  .plan = text.empty() ? campaign::plan_text(plans_, name) : text,
                                  .plan_file = name,
                                  .run = run,
                                  .beside = beside_,
                                  .view_m = view_m},
                                 bench, recording_s);
    });
    preparing_name_ = name;
    cancelled_ = false;
}

bool CampaignHost::begin(const std::function<void()>& may) {
    if (!is_ready(preparing_)) return false;
    campaign::PreparedSession prepared = preparing_.get();
    if (cancelled_) throw InputError{"the campaign was stopped before it began"};
    may();
    begin(std::move(prepared));
    return true;
}

void CampaignHost::begin(campaign::PreparedSession prepared) {
    const std::string name = prepared.settings.plan_file;
    session_ = std::make_shared<campaign::Session>(
        runner_, on_call_, std::move(prepared), [this](const campaign::Event& event, double /*now_s*/) {
            const std::string words = campaign::text(event, session_->engine(), session_->points());
            if (words.empty()) return;
            state_.newest = words;
            log_(words);
        });
    leaving_ = false;
    const std::filesystem::path folder = session_->folder();
    state_ = {.name = name, .title = session_->plan().title, .folder = folder.filename().string()};
    log_(fmt::format("{} begins: {} points, folder {}", state_.name, session_->points().size(),
                     folder.string()));
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
    if (is_ready(finishing_)) log_end();
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
    state_.paused = state_.waits = false;
    try {
        finishing_ = desk_.run([session = session_, last] { return finish(*session, last); });
    } catch (const DeviceError& e) {
        log_(not_written(*session_, e.what()));
    }
    session_.reset();
    if (!beside_) log_end();
}

void CampaignHost::log_end() {
    for (const std::string& sentence : finishing_.get()) log_(sentence);
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
    s.waits = session_->campaign().waits_for_a_person();
    if (const campaign::Point* p = engine.point()) {
        s.number = p->id;
        s.point = campaign::place(*p);
    }
    s.left_s = session_->left_s();
    return s;
}

}  // namespace shaker::service
