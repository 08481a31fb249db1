#include "daemon/remote/bench/instrument.hpp"

#include <spdlog/fmt/fmt.h>

#include <utility>

#include "daemon/commands.hpp"
#include "daemon/remote/scpi/error.hpp"
#include "daemon/remote/scpi/session.hpp"

namespace shaker {

using scpi::Code;
using scpi::Operation;
using scpi::Questionable;

std::string BenchInstrument::identity() const { return "shakerd,bench controller,0," SHAKER_VERSION; }

std::string BenchInstrument::options() const { return "0"; }

std::shared_ptr<const BenchState> BenchInstrument::state() const {
    auto state = book_.now();
    if (!state) throw scpi::Error{Code::stale_data, "the bench has not told of itself yet"};
    return state;
}

// What is not driven needs no stop: *RST is no error then.
void BenchInstrument::reset() {
    const auto now = book_.now();
    if (now && driving(now->state) && now->state != RunState::ramp_down) book_.order(End{}, {});
    periods = RunOptions{}.periods;
    settle = RunOptions{}.settle;
    on_trigger = armed = false;
}

int BenchInstrument::self_test() {
    const auto now = book_.now();
    return now && now->state != RunState::init ? 0 : 1;
}

void BenchInstrument::trigger() {
    if (on_trigger && !std::exchange(armed, false))
        throw scpi::Error{Code::trigger_ignored, "nothing waits for a trigger; INITiate makes it wait"};
    book_.order(next(), {});
}

void BenchInstrument::save(int place) { saved_.at(static_cast<std::size_t>(place)) = book_.drive(); }

void BenchInstrument::recall(int place) {
    const auto& saved = saved_.at(static_cast<std::size_t>(place));
    if (!saved)
        throw scpi::Error{Code::settings_conflict, fmt::format("nothing was saved in place {}", place)};
    book_.order(SetDrive{*saved}, {});
}

void BenchInstrument::abort(const scpi::Session& by) {
    armed = false;
    book_.abort(by.name());
    aborted_(by);
}

Begin BenchInstrument::next() const {
    const auto now = state();
    return {periods.value_or(now->periods), settle.value_or(now->settle)};
}

void BenchInstrument::order(const scpi::Session& session, OrderWhat what) {
    book_.order(std::move(what), [this, who = session.name()](const std::string& refused) {
        if (!refused.empty()) refused_(who, refused);
    });
}

void show(const BenchState& s, scpi::DeviceStatus& status) {
    status.set(Operation::calibrating, s.state == RunState::identify);
    status.set(Operation::settling, s.state == RunState::ramp || s.state == RunState::ramp_down ||
                                        (s.state == RunState::run && !s.measuring));
    status.set(Operation::recording, !s.recording.name.empty());
    status.set(Operation::equaliser_active, s.state == RunState::run);
    status.set(Operation::output_on, driving(s.state));
    status.set(Operation::reduction_steady, s.measuring);
    status.set(Questionable::drive_limited, s.reached < 1);
    status.set(Questionable::phase, s.state == RunState::run && !s.locked);
    status.set(Questionable::calibration, s.response == nullptr);
    status.set(Questionable::abort_latched, s.state == RunState::tripped);
    status.set(Questionable::open_channel, s.trip && s.trip->cause == Cause::sensor_open);
    status.set(Questionable::tracking_lost, s.walker && s.walker->lost > 0);
    const LostState& l = s.lost;
    status.set(Questionable::data_loss,
               l.plays + l.changes + l.blocks + l.frames + l.trips + s.recording.pieces_lost > 0);
}

}  // namespace shaker
