// Measurements started by a command, a trigger or a query that waits for the result.
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "daemon/remote/instrument/instrument.hpp"
#include "daemon/remote/scpi/error.hpp"
#include "daemon/remote/scpi/reply.hpp"
#include "daemon/remote/scpi/session.hpp"
#include "drivers/drive.hpp"

namespace shaker::instrument {

namespace {

using scpi::Command;

/// The first measurement that begins after all earlier orders are in force.
class NextMeasurement {
public:
    explicit NextMeasurement(BenchInstrument& bench)
        : bench_{bench}, ordered_{bench.pending_orders().bench_port().ordered()} {}

    /// True when it is reduced, or when it cannot be because nothing is driven any more.
    [[nodiscard]] bool over() {
        const auto state = bench_.state();
        if (state->answered < ordered_) return false;
        if (std::isnan(from_s_)) from_s_ = state->now_s;
        return state->measured_from_s >= from_s_ || (!bench_.pending() && !driving(state->state));
    }

    void reply(scpi::Reply& reply) const {
        const auto state = bench_.state();
        if (!(state->measured_from_s >= from_s_))
            throw scpi::Error{scpi::Code::stale_data,
                              state->trip ? "READ?: stopped: " + text(*state->trip)
                                          : "READ?: the run ended before a measurement was complete"};
        reply_drift(*state, reply);
    }

private:
    BenchInstrument& bench_;
    std::uint64_t ordered_;
    double from_s_ = NAN;  // master time
};

void read(BenchInstrument& bench, scpi::Call& call) {
    const auto state = bench.state();
    if (bench.on_trigger && !driving(state->state))
        throw scpi::Error{scpi::Code::trigger_deadlock,
                          "READ? with TRIGger:SOURce BUS would wait for ever; set TRIGger:SOURce IMMediate"};
    if (state->state == run::RunState::tripped)
        throw scpi::Error{scpi::Code::settings_conflict, "stopped: " + text(*state->trip)};
    if (!driving(state->state) || state->state == run::RunState::ramp_down)
        bench.order(call.session, bench.next());
    const auto next = std::make_shared<NextMeasurement>(bench);
    call.session.pause({[next] { return next->over(); }, [next](scpi::Reply& reply) { next->reply(reply); }});
}

void measure(BenchInstrument& bench, scpi::Call& call) {
    Drive drive = bench.pending_orders().drive();
    double* const places[] = {&drive.frequency, &drive.gamma, &drive.rho, &drive.phi};
    for (std::size_t i = 0; i < std::size(places) && call.arguments[i].given; ++i)
        *places[i] = call.arguments[i].number;
    if (call.arguments[0].given) bench.order(call.session, service::SetDrive{drive});
    read(bench, call);
}

/// Sets and queries the parameter of row i of measurement_fields.
Command plan_command(BenchInstrument& bench, std::size_t i) {
    const MeasurementField& field = measurement_fields.at(i);
    const auto [least, most] = field.allowed;
    const scpi::Parameter parameter =
        field.word.empty() ? scpi::integer(least, most, MeasurementPlan{}.*field.member)
                           : scpi::or_word(field.word, scpi::integer(std::max(1.0, least), most));
    return {.header = std::string{field.header},
            .parameters = {parameter},
            .set =
                [&bench, i](scpi::Call& call) {
                    const scpi::Argument& a = call.arguments[0];
                    bench.given.at(i) = a.word == 0 ? 0 : static_cast<int>(a.number);
                },
            .query =
                [&bench, &field, parameter](scpi::Call& call) {
                    const int value = bench.next().plan.*field.member;
                    if (value == 0 && !field.word.empty())
                        return call.reply.word(parameter.words.front().short_form);
                    call.reply.integer(value);
                },
            .guarded = true};
}

}  // namespace

std::shared_ptr<const reduction::Reduction> result_of(const service::BenchState& state) {
    if (state.result) return state.result;
    throw scpi::Error{scpi::Code::stale_data,
                      state.not_reduced.empty() ? "no measurement is complete yet" : state.not_reduced};
}

void reply_drift(const service::BenchState& state, scpi::Reply& reply) {
    const auto r = result_of(state);
    reply.number(r->v_D.value);
    reply.number(r->v_D.sigma);
    reply.number(r->D.value);
    reply.integer(static_cast<std::int64_t>(r->periods.size()));
    reply.boolean(state.measuring);
}

void reply_no_drift(scpi::Reply& reply) {
    scpi::nans<3>(reply);
    reply.integer(0);
    reply.boolean(false);
}

std::vector<Command> read_commands(BenchInstrument& bench) {
    const DriveLimits& l = drive_limits;
    const auto given = [](const char* unit, Range r) {
        return scpi::optional(scpi::number(unit, r.min, r.max));
    };
    std::vector<Command> rows;
    rows.push_back({.header = "INITiate[:IMMediate]",
                    .set =
                        [&bench](scpi::Call& call) {
                            if (driving(bench.state()->state))
                                throw scpi::Error{scpi::Code::init_ignored,
                                                  "a run is in progress; send OUTPut OFF first"};
                            if (bench.on_trigger)
                                bench.armed = true;
                            else
                                bench.order(call.session, bench.next());
                        },
                    .guarded = true});
    rows.push_back({.header = "INITiate:CONTinuous", .query = [&bench](scpi::Call& call) {
                        call.reply.boolean(bench.next().plan.measurements == 0);
                    }});
    for (std::size_t i = 0; i < measurement_fields.size(); ++i) rows.push_back(plan_command(bench, i));
    rows.push_back(
        {.header = "TRIGger:SOURce",
         .parameters = {scpi::choice("IMMediate|BUS")},
         .set =
             [&bench](scpi::Call& call) {
                 bench.on_trigger = call.arguments[0].word == 1;
                 bench.armed = false;
             },
         .query = [&bench](scpi::Call& call) { call.reply.word(bench.on_trigger ? "BUS" : "IMM"); },
         .guarded = true});
    rows.push_back({.header = "READ[:DRIFt]",
                    .query =
                        [&bench](scpi::Call& call) {
                            call.session.require_control();
                            read(bench, call);
                        },
                    .without = reply_no_drift});
    rows.push_back({.header = "MEASure[:DRIFt]",
                    .query =
                        [&bench](scpi::Call& call) {
                            call.session.require_control();
                            measure(bench, call);
                        },
                    .query_parameters = {given("HZ", l.frequency), given("M/S2", l.gamma), given("", l.rho),
                                         given("RAD", l.phi)},
                    .without = reply_no_drift});
    return rows;
}

}  // namespace shaker::instrument
