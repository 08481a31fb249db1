#include "daemon/service/pending_orders.hpp"

#include <utility>

#include "daemon/service/order_texts.hpp"
#include "drivers/errors.hpp"

namespace shaker::service {

PendingOrders::Settings PendingOrders::settings() const {
    if (under_way_ > 0) return ordered_;
    const auto state = now();
    if (!state) return {};
    return {state->wanted,
            state->limits,
            {state->record, state->record_name, state->pictures},
            {state->plan},
            state->closed_loop};
}

bool PendingOrders::pending() const {
    if (under_way_ > 0) return true;
    const auto state = now();
    if (!state || state->aborts < bench_port_.aborted()) return true;
    if (state->campaign && state->campaign->active && !state->campaign->paused) return true;
    if (state->state == run::RunState::tripped) return !state->may_clear;
    if (state->state == run::RunState::idle) return !state->recording.name.empty();  // it is being finished
    return state->to_middle || row_of(state->state).pending;
}

void PendingOrders::order(OrderWhat what, const std::string& by, Answered answered) {
    ordered_ = settings();
    if (const auto* set = std::get_if<SetDrive>(&what)) ordered_.drive = set->drive;
    if (const auto* lower = std::get_if<LowerLimit>(&what)) try {
            safety::lower(ordered_.limits, lower->key, lower->value);
        } catch (const InputError&) {  // the bench will refuse it, too
        }
    if (const auto* record = std::get_if<Record>(&what)) ordered_.record = *record;
    if (const auto* run = std::get_if<Begin>(&what)) ordered_.run = *run;
    if (const auto* loop = std::get_if<CloseLoop>(&what)) ordered_.closed_loop = loop->on;
    ++under_way_;
    // The port may answer after the end of this object; `later` then drops the function.
    const OrderText words = words_of(what);
    bench_port_.order({std::move(what), [this, later = later_, answered = std::move(answered), words,
                                         by](const std::string& refused) {
                           later([this, answered, refused, words, by] {
                               --under_way_;
                               if (refused.empty() && !words.text.empty()) log(words, by);
                               if (answered) answered(refused);
                           });
                       }});
}

void PendingOrders::log(const OrderText& words, const std::string& by) {
    const auto state = now();
    const std::string text = words.text + " by " + by;
    bench_port_.log(state ? state->now_s : 0, words.kind, text, words.key.empty() ? text : words.key);
}

}  // namespace shaker::service
