// What is begun by a command, a trigger or a query that answers when it is measured.
#include <spdlog/fmt/fmt.h>

#include <cmath>
#include <memory>

#include "daemon/remote/bench/commands.hpp"
#include "daemon/remote/scpi/error.hpp"
#include "daemon/remote/scpi/reply.hpp"
#include "daemon/remote/scpi/session.hpp"
#include "drivers/drive_limits.hpp"

namespace shaker {

namespace {

using scpi::Call;
using scpi::Code;
using scpi::Command;
using scpi::Error;

/// The next measurement that begins when all that was ordered before is in force.
class NextMeasurement {
public:
    explicit NextMeasurement(BenchInstrument& bench)
        : bench_{bench}, ordered_{bench.book().desk().ordered()} {}

    /// It is reduced, or will not be: nothing is driven any more.
    [[nodiscard]] bool over() {
        const auto state = bench_.state();
        if (state->answered < ordered_) return false;
        if (std::isnan(from_s_)) from_s_ = state->now_s;
        return state->measured_from_s >= from_s_ || (!bench_.pending() && !driving(state->state));
    }

    void tell(scpi::Reply& reply) const {
        const auto state = bench_.state();
        if (!(state->measured_from_s >= from_s_))
            throw Error{Code::stale_data, state->trip ? "READ?: stopped: " + text(*state->trip)
                                                      : "READ?: the run ended before a measurement did"};
        tell_drift(*state, reply);
    }

private:
    BenchInstrument& bench_;
    std::uint64_t ordered_;
    double from_s_ = NAN;  // master time
};

void read(BenchInstrument& bench, Call& call) {
    const auto state = bench.state();
    if (bench.on_trigger && !driving(state->state))
        throw Error{Code::trigger_deadlock, "TRIGger:SOURce BUS: nobody could trigger what is waited for"};
    if (state->state == RunState::tripped)
        throw Error{Code::settings_conflict, "stopped: " + text(*state->trip)};
    if (!driving(state->state) || state->state == RunState::ramp_down)
        bench.order(call.session, bench.next());
    const auto next = std::make_shared<NextMeasurement>(bench);
    call.session.pause({[next] { return next->over(); }, [next](scpi::Reply& reply) { next->tell(reply); }});
}

void measure(BenchInstrument& bench, Call& call) {
    Drive drive = bench.book().drive();
    double* const places[] = {&drive.frequency, &drive.gamma, &drive.rho, &drive.phi};
    for (std::size_t i = 0; i < std::size(places) && call.arguments[i].given; ++i)
        *places[i] = call.arguments[i].number;
    if (call.arguments[0].given) bench.order(call.session, SetDrive{drive});
    read(bench, call);
}

}  // namespace

std::shared_ptr<const Reduction> result_of(const BenchState& state) {
    if (state.result) return state.result;
    throw Error{Code::stale_data,
                state.not_reduced.empty() ? "no measurement is complete yet" : state.not_reduced};
}

void tell_drift(const BenchState& state, scpi::Reply& reply) {
    const auto r = result_of(state);
    reply.number(r->v_D.value);
    reply.number(r->v_D.sigma);
    reply.number(r->D.value);
    reply.integer(static_cast<std::int64_t>(r->periods.size()));
    reply.boolean(state.measuring);
}

std::vector<Command> read_commands(BenchInstrument& bench) {
    const DriveLimits& l = drive_limits;
    const auto given = [](const char* unit, Range r) {
        return scpi::optional(scpi::number(unit, r.min, r.max));
    };
    std::vector<Command> rows;
    rows.push_back({.header = "INITiate[:IMMediate]",
                    .set =
                        [&bench](Call& call) {
                            if (driving(bench.state()->state))
                                throw Error{Code::init_ignored, "it is driven already"};
                            if (bench.on_trigger)
                                bench.armed = true;
                            else
                                bench.order(call.session, bench.next());
                        },
                    .guarded = true});
    rows.push_back({.header = "INITiate:CONTinuous",
                    .query = [](Call& call) { call.reply.boolean(true); }});  // until OUTPut OFF
    rows.push_back({.header = "TRIGger:SOURce",
                    .parameters = {scpi::choice("IMMediate|BUS")},
                    .set =
                        [&bench](Call& call) {
                            bench.on_trigger = call.arguments[0].word == 1;
                            bench.armed = false;
                        },
                    .query = [&bench](Call& call) { call.reply.word(bench.on_trigger ? "BUS" : "IMM"); },
                    .guarded = true});
    rows.push_back({.header = "READ[:DRIFt]", .query = [&bench](Call& call) {
                        call.session.require_control();
                        read(bench, call);
                    }});
    rows.push_back({.header = "MEASure[:DRIFt]",
                    .query =
                        [&bench](Call& call) {
                            call.session.require_control();
                            measure(bench, call);
                        },
                    .query_parameters = {given("HZ", l.frequency), given("M/S2", l.gamma), given("", l.rho),
                                         given("RAD", l.phi)}});
    return rows;
}

}  // namespace shaker
