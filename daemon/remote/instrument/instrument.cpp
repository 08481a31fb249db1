#include "daemon/remote/instrument/instrument.hpp"

#include <spdlog/fmt/fmt.h>

#include <utility>

#include "daemon/remote/scpi/error.hpp"
#include "daemon/remote/scpi/standard_commands.hpp"

namespace shaker::instrument {

using scpi::Code;
using scpi::Operation;
using scpi::Questionable;

std::string BenchInstrument::identity() const { return "shakerd,bench controller,0," SHAKER_VERSION; }

std::string BenchInstrument::options() const { return "0"; }

std::shared_ptr<const service::BenchState> BenchInstrument::state() const {
    auto state = pending_orders_.now();
    if (!state) throw scpi::Error{scpi::Code::stale_data, "the bench has not reported its state yet"};
    return state;
}

// *RST is no error while nothing is driven.
void BenchInstrument::reset(const scpi::Session& by) {
    const auto now = pending_orders_.now();
    if (now && driving(now->state) && now->state != run::RunState::ramp_down) order(by, service::End{});
    for (std::size_t i = 0; i < given.size(); ++i)
        given.at(i) = MeasurementPlan{}.*measurement_fields.at(i).member;
    on_trigger = armed = false;
}

int BenchInstrument::self_test() {
    const auto now = pending_orders_.now();
    return now && now->state != run::RunState::init ? 0 : 1;
}

void BenchInstrument::trigger(const scpi::Session& by) {
    if (on_trigger && !std::exchange(armed, false))
        throw scpi::Error{scpi::Code::trigger_ignored,
                          "no measurement waits for a trigger; send INITiate first"};
    order(by, next());
}

void BenchInstrument::save(int place) {
    saved_.at(static_cast<std::size_t>(place)) = pending_orders_.drive();
}

void BenchInstrument::recall(const scpi::Session& by, int place) {
    const auto& saved = saved_.at(static_cast<std::size_t>(place));
    if (!saved)
        throw scpi::Error{scpi::Code::settings_conflict,
                          fmt::format("place {} is empty; save settings with *SAV first", place)};
    order(by, service::SetDrive{*saved});
}

access::Aborts::Receipt BenchInstrument::abort(const scpi::Session& by) { return aborts_.give(by.name()); }

service::Begin BenchInstrument::next() const {
    service::Begin begin{state()->plan};
    for (std::size_t i = 0; i < given.size(); ++i)
        if (given.at(i)) begin.plan.*measurement_fields.at(i).member = *given.at(i);
    return begin;
}

void BenchInstrument::order(const scpi::Session& session, service::OrderWhat what) {
    pending_orders_.order(std::move(what), session.name(),
                          [this, who = session.name()](const std::string& refused) {
                              if (!refused.empty()) refused_(who, refused);
                          });
}

void show(const service::BenchState& s, scpi::DeviceStatus& status) {
    status.trips = s.trips;
    status.set(scpi::Operation::calibrating, s.state == run::RunState::identify);
    status.set(scpi::Operation::settling,
               row_of(s.state).settling || (s.state == run::RunState::run && !s.measuring));
    status.set(scpi::Operation::recording, !s.recording.name.empty());
    status.set(scpi::Operation::equaliser_active, s.state == run::RunState::run);
    status.set(scpi::Operation::output_on, driving(s.state));
    status.set(scpi::Operation::reduction_steady, s.measuring);
    status.set(scpi::Questionable::drive_limited, s.reached < 1);
    status.set(scpi::Questionable::phase, s.state == run::RunState::run && !s.locked);
    status.set(scpi::Questionable::calibration, s.response == nullptr);
    status.set(scpi::Questionable::abort_latched, s.state == run::RunState::tripped);
    status.set(scpi::Questionable::open_channel, s.trip && s.trip->cause == safety::Cause::sensor_open);
    status.set(scpi::Questionable::tracking_lost, s.walker && s.walker->lost > 0);
    const service::LostState& l = s.lost;
    status.set(scpi::Questionable::data_loss,
               l.plays + l.changes + l.blocks + l.frames + l.trips + s.recording.pieces_lost > 0);
}

std::vector<scpi::Command> command_table(BenchInstrument& bench) {
    std::vector<scpi::Command> rows;
    for (auto* part : {&source_commands, &shape_commands, &output_commands, &control_commands, &read_commands,
                       &fetch_commands, &campaign_commands, &record_commands, &sense_commands,
                       &published_commands, &bench_commands})
        for (scpi::Command& row : part(bench)) rows.push_back(std::move(row));
    return scpi::with_standard_commands(std::move(rows));
}

}  // namespace shaker::instrument
