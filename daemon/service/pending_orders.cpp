#include "daemon/service/pending_orders.hpp"

#include <spdlog/fmt/fmt.h>

#include <utility>

#include "daemon/catalogue/catalogue.hpp"
#include "daemon/service/made_order.hpp"
#include "drivers/errors.hpp"
#include "drivers/text/printable.hpp"

namespace shaker::service {

namespace {

constexpr std::size_t longest_name = 64;

/// "3 x 20 periods", "40 periods, until stopped".
std::string plan_words(const MeasurementPlan& plan) {
    return plan.measurements == 0 ? fmt::format("{} periods, until stopped", plan.periods)
                                  : fmt::format("{} x {} periods", plan.measurements, plan.periods);
}

std::string drive_words(const Drive& d) {
    return fmt::format("{:.6g} Hz, gamma {:.4g} g, rho {:.4g}, phi {:.4g} deg{}", d.frequency,
                       d.gamma / paper_g, d.rho, d.phi * 360 / two_pi,
                       d.biharmonic() ? "" : ", with overtones");
}

/// Orders whose values matter; the rows have the words of the others. Remarks, mu and settings files are
/// logged by the bench.
struct InWords {
    OrderText operator()(const SetDrive& order) const {
        return {"setting", "", "set-point " + drive_words(order.drive)};
    }
    OrderText operator()(const Begin& order) const {
        const std::string at = order.drive ? " at the new set-point " + drive_words(*order.drive) : "";
        return {"order", "start", "start (" + plan_words(order.plan) + ")" + at};
    }
    OrderText operator()(const MeasurePlan& order) const {
        return {"order", "campaign", "campaign " + order.name};
    }
    OrderText operator()(const CheckPlan& order) const { return {"order", "check of plan " + order.name}; }
    OrderText operator()(const TellCampaign& order) const {
        const std::string word{campaign::word_names.at(static_cast<std::size_t>(order.word))};
        return {"order", "campaign " + word};
    }
    OrderText operator()(const Record& order) const {
        const std::string name = order.name.empty() ? "" : " as " + order.name;
        return {"setting", "recording", order.on ? "recording on" + name : "recording off"};
    }
    OrderText operator()(const CloseLoop& order) const {
        return {"setting", "loop", order.on ? "loop closed" : "loop open"};
    }
    OrderText operator()(const LowerLimit& order) const {
        const auto [name, per_si] = safety::file_name(order.key);
        return {"setting", "limit", fmt::format("limit {} tightened to {:.6g}", name, per_si * order.value)};
    }
    OrderText operator()(const MoveTargets& order) const {
        std::string regions;
        for (const acquisition::MovedTarget& m : order.targets)
            regions += (regions.empty() ? "" : "; ") + acquisition::text(m);
        return {"setting", "targets", "targets moved until the daemon ends: " + regions};
    }
    OrderText operator()(const auto& order) const {
        const std::string_view log = row_of(order).log;
        return {log.empty() ? "setting" : "order", std::string{log}};
    }
};

}  // namespace

OrderText words_of(const OrderWhat& what) { return std::visit(InWords{}, what); }

void require_name(const std::string& what, const std::string& name) {
    if (name.size() <= longest_name && catalogue::listed_name(name + ".nxs")) return;
    throw InputError{
        fmt::format("{} \"{}\": expected 1 to {} letters, digits, dots, hyphens and underscores, without "
                    "a dot in front",
                    what, name.substr(0, longest_name), longest_name)};
}

void require_remark(const std::string& text) {
    if (!text.empty() && text.size() <= Remark::longest && printable(text) == text) return;
    throw InputError{
        fmt::format("remark of {} bytes: 1 to {} bytes of UTF-8 without control characters are "
                    "allowed",
                    text.size(), Remark::longest)};
}

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
    if (const auto* run = std::get_if<Begin>(&what)) {
        ordered_.run = {run->plan};
        ordered_.drive = run->drive.value_or(ordered_.drive);
    }
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
