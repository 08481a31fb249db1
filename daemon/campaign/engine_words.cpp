// What a person may say to a campaign, and its pauses.
#include <algorithm>
#include <utility>

#include "daemon/campaign/engine.hpp"
#include "drivers/errors.hpp"

namespace shaker::campaign {

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

}  // namespace shaker::campaign
