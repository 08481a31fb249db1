// What a person may say to a campaign, what it says, and its pauses.
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <utility>

#include "daemon/campaign/engine.hpp"
#include "drivers/errors.hpp"

namespace shaker::campaign {

namespace {
constexpr double kept_bytes = 100e6;  // of the disk, for the end of the recording and the journal
constexpr double most_around_s = 60;  // of a pass, besides measuring
}  // namespace

std::string Engine::doing() const {
    constexpr std::array words{"changing", "measuring", "returning"};
    return done_ ? "ended" : paused_ ? "paused" : words.at(static_cast<std::size_t>(phase_));
}

void Engine::obey(Word word) {
    if (done_) throw InputError{"the campaign has ended"};
    switch (word) {
        case Word::pause:
            return pause("by the operator");
        case Word::resume:
            if (!paused_) throw InputError{"the campaign is not paused"};
            if (tripped_) throw InputError{"the drive has tripped; clear the trip first, then resume"};
            paused_ = false;
            events_.emplace_back(
                CampaignChange{.what = CampaignChange::What::resumed, .reason = "by the operator"});
            return;
        case Word::skip:
            if (at_ == points_.size()) throw InputError{"no point is left to skip"};
            end_point(Outcome::left_out, "by the operator");
            return to_next();
        case Word::repeat:
            return repeat();
        case Word::stop:
            stop_ = true;
            return;
    }
}

// The point that ended last is measured again, after the one in progress.
void Engine::repeat() {
    const auto p = std::ranges::find(points_, last_.point, &Point::id);
    if (p == points_.end()) throw InputError{"no point has ended yet that could be repeated"};
    const auto i = static_cast<std::size_t>(p - points_.begin());
    static const std::string reason = "repeated by the operator";
    for (const int pass : last_.passes) events_.emplace_back(PassLost{last_.point, pass, reason});
    if (last_.passes.empty()) events_.emplace_back(PointBegun{.point = last_.point});
    results_.erase(last_.point);
    if (choice_) choice_->forget(last_.point);
    last_ = {};
    over_[i] = false;
    --ended_;
    if (!begun_) to_next();
}

void Engine::refused(const std::string& why) {
    phase_ = Phase::between;
    under_way_ = false;
    pause("the bench refused the drive: " + why + "; put that right, then resume, or skip the point");
}

void Engine::pause(std::string reason) {
    if (!std::exchange(paused_, true))
        events_.emplace_back(
            CampaignChange{.what = CampaignChange::What::paused, .reason = std::move(reason)});
}

// Empty: the disk has room for the point.
std::string Engine::disk_is_short(const Seen& seen, const Travel& travel) const {
    const double passes_s = std::max(travel.passes, 1) * most_around_s;
    const double needed = seen.bytes_per_s * (passes_s + travel.measured() * travel.period_s) + kept_bytes;
    if (!(seen.free_bytes < needed)) return {};
    return fmt::format("the disk has {:.0f} MB left and point {} may need {:.0f} MB: make room, then resume",
                       1e-6 * seen.free_bytes, points_[at_].id, 1e-6 * needed);
}

}  // namespace shaker::campaign
