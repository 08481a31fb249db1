#include <limits>

#include "daemon/remote/instrument/instrument.hpp"
#include "daemon/remote/scpi/error.hpp"
#include "daemon/remote/scpi/reply.hpp"
#include "daemon/remote/scpi/session.hpp"

namespace shaker::instrument {

namespace {

using scpi::Command;

void output(BenchInstrument& bench, scpi::Call& call) {
    const bool on = call.arguments[0].on;
    const auto state = bench.state();
    const bool is_on = driving(state->state) && state->state != run::RunState::ramp_down;
    if (on && state->state == run::RunState::tripped)
        throw scpi::Error{scpi::Code::settings_conflict, "OUTPut ON while stopped: " + text(*state->trip)};
    bench.armed = false;
    if (on == is_on && !bench.pending()) return;
    if (on)
        bench.order(call.session, bench.next());
    else
        bench.order(call.session, service::End{});
}

}  // namespace

std::vector<Command> output_commands(BenchInstrument& bench) {
    std::vector<Command> rows;
    for (const char* way : {"UP", "DOWN"})
        rows.push_back(asks(bench, std::string{"OUTPut:RAMP:"} + way, [&bench](const auto& s) {
            return s.facts->soft_start_periods / bench.pending_orders().drive().frequency;
        }));
    rows.push_back({.header = "OUTPut[:STATe]",
                    .parameters = {scpi::boolean()},
                    .set = [&bench](scpi::Call& call) { output(bench, call); },
                    .query = one([&bench] {
                        const run::RunState s = bench.state()->state;
                        return driving(s) && s != run::RunState::ramp_down;
                    }),
                    .guarded = true});
    rows.push_back(command_of(bench, "middle", one([&bench] { return bench.state()->to_middle; })));
    rows.push_back(command_of(bench, "reset-walker"));
    rows.push_back(command_of(bench, "mu"));
    rows.push_back(
        asks(bench, "OUTPut:ENABle", [](const auto& s) { return s.enable_output.value_or(false); }));
    rows.push_back(asks(bench, "OUTPut:PROTection:CAUSe",
                        [](const auto& s) { return s.trip ? text(*s.trip) : std::string{}; }));
    rows.push_back({.header = "OUTPut:PROTection:CLEar",
                    .set =
                        [&bench](scpi::Call& call) {
                            bench.order(call.session, service::ClearTrip{call.session.trips()});
                        },
                    .guarded = true});
    rows.push_back({.header = "OUTPut:PROTection:LEVel",
                    .parameters = {scpi::number("V", 0, std::numeric_limits<double>::max())},
                    .set =
                        [&bench](scpi::Call& call) {
                            bench.order(call.session, service::LowerLimit{{&safety::Limits::drive},
                                                                          call.arguments[0].number});
                        },
                    .query = one([&bench] { return bench.pending_orders().limits().drive.abort; }),
                    .guarded = true});
    return rows;
}

}  // namespace shaker::instrument
