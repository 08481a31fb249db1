#include "daemon/service/pending_orders.hpp"

#include <utility>

namespace shaker::service {

PendingOrders::Settings PendingOrders::settings() const {
    if (under_way_ > 0) return ordered_;
    const auto state = now();
    if (!state) return {};
    return {state->wanted,
            state->limits,
            {state->record, state->record_name, state->pictures},
            {state->periods, state->settle},
            state->closed_loop};
}

bool PendingOrders::pending() const {
    if (under_way_ > 0) return true;
    const auto state = now();
    if (!state || state->aborts < bench_port_.aborted()) return true;
    switch (state->state) {
        case run::RunState::init:
        case run::RunState::self_test:
        case run::RunState::armed:
        case run::RunState::identify:
        case run::RunState::ramp:
        case run::RunState::ramp_down:
            return true;
        case run::RunState::tripped:
            return !state->may_clear;
        case run::RunState::idle:
            return !state->recording.name.empty();  // a recording is being finished
        case run::RunState::run:
            return false;
    }
    return false;
}

void PendingOrders::order(OrderWhat what, Answered answered) {
    ordered_ = settings();
    if (const auto* set = std::get_if<SetDrive>(&what)) ordered_.drive = set->drive;
    if (const auto* lower = std::get_if<LowerLimits>(&what)) ordered_.limits = lower->limits;
    if (const auto* record = std::get_if<Record>(&what)) ordered_.record = *record;
    if (const auto* run = std::get_if<Begin>(&what)) ordered_.run = *run;
    if (const auto* loop = std::get_if<CloseLoop>(&what)) ordered_.closed_loop = loop->on;
    ++under_way_;
    // The port may answer after the end of this object; `later` then drops the function.
    bench_port_.order(
        {std::move(what), [this, later = later_, answered = std::move(answered)](const std::string& refused) {
             later([this, answered, refused] {
                 --under_way_;
                 if (answered) answered(refused);
             });
         }});
}

}  // namespace shaker::service
