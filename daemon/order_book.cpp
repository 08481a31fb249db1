#include "daemon/order_book.hpp"

#include <utility>

namespace shaker {

Drive OrderBook::drive() const {
    if (under_way_ > 0) return drive_;
    const auto state = now();
    return state ? state->wanted : Drive{};
}

int OrderBook::periods() const {
    const auto state = now();
    return state ? state->periods : 0;
}

Limits OrderBook::limits() const {
    if (under_way_ > 0) return limits_;
    const auto state = now();
    return state ? state->limits : Limits{};
}

bool OrderBook::pending() const {
    if (under_way_ > 0) return true;
    const auto state = now();
    if (!state || state->aborts < desk_.aborted()) return true;
    switch (state->state) {
        case RunState::init:
        case RunState::self_test:
        case RunState::armed:
        case RunState::identify:
        case RunState::ramp:
        case RunState::ramp_down:
            return true;
        case RunState::tripped:
            return !state->may_clear;
        case RunState::idle:
        case RunState::run:
            return false;
    }
    return false;
}

void OrderBook::order(OrderWhat what, Answered answered) {
    if (under_way_ == 0) {
        drive_ = drive();
        limits_ = limits();
    }
    if (const auto* set = std::get_if<SetDrive>(&what)) drive_ = set->drive;
    if (const auto* lower = std::get_if<LowerLimits>(&what)) limits_ = lower->limits;
    ++under_way_;
    // The desk may answer when this is gone: what is run later then is not run.
    desk_.order(
        {std::move(what), [this, later = later_, answered = std::move(answered)](const std::string& refused) {
             later([this, answered, refused] {
                 --under_way_;
                 if (answered) answered(refused);
             });
         }});
}

}  // namespace shaker
