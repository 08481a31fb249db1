#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <limits>
#include <numbers>

#include "daemon/control/equaliser.hpp"
#include "daemon/remote/instrument/commands.hpp"
#include "daemon/remote/scpi/data/error.hpp"
#include "daemon/remote/scpi/data/reply.hpp"
#include "daemon/remote/scpi/session.hpp"
#include "daemon/remote/scpi/standard_commands.hpp"
#include "daemon/run/run_settings.hpp"

namespace shaker::instrument {

namespace {

using scpi::Call;
using scpi::Code;
using scpi::Command;
using scpi::Error;

/// A command that sets and queries one number of the drive.
Command drive_row(BenchInstrument& bench, const char* header, const char* unit, Range range, double standard,
                  double Drive::*member) {
    return {.header = header,
            .parameters = {scpi::number(unit, range.min, range.max, standard)},
            .set =
                [&bench, member](scpi::Call& call) {
                    Drive drive = bench.pending_orders().drive();
                    drive.*member = call.arguments[0].number;
                    bench.order(call.session, service::SetDrive{drive});
                },
            .query = [&bench, member](
                         scpi::Call& call) { call.reply.number(bench.pending_orders().drive().*member); },
            .guarded = true};
}

void apply(BenchInstrument& bench, scpi::Call& call) {
    const auto a = call.arguments;
    bench.order(call.session, service::SetDrive{{a[0].number, a[1].number, a[2].number, a[3].number, {}}});
}

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

void harmonics_row(BenchInstrument& bench, scpi::Call& call) {
    const auto state = bench.state();
    if (!state->base) throw scpi::Error{scpi::Code::stale_data, "no period has been measured yet"};
    const int order = call.arguments.empty() || !call.arguments[0].given
                          ? state->base->controlled
                          : static_cast<int>(call.arguments[0].number);
    std::vector<double> pairs;
    for (int q = 1; q <= order; ++q) {
        const std::complex<double> a = state->base->harmonics.at(static_cast<std::size_t>(q - 1)).measured;
        pairs.push_back(std::abs(a));
        pairs.push_back(std::arg(a));
    }
    call.reply.numbers(pairs);
}

/// PREDict:<quantity>?: predicted peak and its limit, in the units of the limits.
Command predicted_row(BenchInstrument& bench, const std::string& quantity) {
    std::string name = quantity;
    const std::size_t shortened = 4;
    for (std::size_t i = 0; i < std::min(shortened, name.size()); ++i)
        name[i] = static_cast<char>(std::toupper(static_cast<unsigned char>(name[i])));
    return {.header = "[SOURce:]PREDict:" + name,
            .query =
                [&bench, quantity](scpi::Call& call) {
                    const auto state = bench.state();
                    for (const safety::Demand& d : state->predicted) {
                        if (d.quantity != quantity) continue;
                        call.reply.number(d.value);
                        return call.reply.number(d.limit);
                    }
                    throw scpi::Error{scpi::Code::stale_data, "no prediction for " + quantity};
                },
            .without = scpi::nans<2>};
}

void response(BenchInstrument& bench, scpi::Call& call) {
    const auto found = bench.state()->response;
    if (!found) throw scpi::Error{scpi::Code::stale_data, "the shaker has not been identified yet"};
    std::vector<double> rows;
    for (int q = 1; q <= found->harmonics; ++q) {
        const auto i = static_cast<std::size_t>(q - 1);
        for (const double x : {q * found->frequency, std::abs(found->h.at(i)), std::arg(found->h.at(i)),
                               found->coherence.at(i), found->floor.at(i)})
            rows.push_back(x);
    }
    call.reply.numbers(rows);
}

double loop_error(const service::BenchState& s) {
    if (!s.base) return std::nan("");
    double worst = 0;
    for (int q = 1; q <= s.base->controlled; ++q) {
        const service::HarmonicState& h = s.base->harmonics.at(static_cast<std::size_t>(q - 1));
        worst = std::max(worst, std::abs(h.measured - h.target));
    }
    return worst / s.wanted.gamma;
}

}  // namespace

std::vector<Command> drive_commands(BenchInstrument& bench) {
    const DriveLimits& l = drive_limits;
    const auto frequency = scpi::number("HZ", l.frequency.min, l.frequency.max, 20);
    const auto gamma = scpi::number("M/S2", l.gamma.min, l.gamma.max, paper_g);
    const auto rho = scpi::number("", l.rho.min, l.rho.max, 0.5);
    const auto phi = scpi::number("RAD", l.phi.min, l.phi.max, 0);
    std::vector<Command> rows;
    rows.push_back(drive_row(bench, "[SOURce:]FREQuency[:FIXed]", "HZ", l.frequency, 20, &Drive::frequency));
    rows.push_back(
        drive_row(bench, "[SOURce:]ACCeleration[:LEVel]", "M/S2", l.gamma, paper_g, &Drive::gamma));
    rows.push_back(drive_row(bench, "[SOURce:]BIHarmonic:RHO", "", l.rho, 0.5, &Drive::rho));
    rows.push_back(drive_row(bench, "[SOURce:]BIHarmonic:PHASe", "RAD", l.phi, 0, &Drive::phi));
    rows.push_back({.header = "[SOURce:]APPLy:BIHarmonic",
                    .parameters = {frequency, gamma, rho, phi},
                    .set = [&bench](scpi::Call& call) { apply(bench, call); },
                    .query =
                        [&bench](scpi::Call& call) {
                            const Drive d = bench.pending_orders().drive();
                            for (const double x : {d.frequency, d.gamma, d.rho, d.phi}) call.reply.number(x);
                        },
                    .guarded = true});
    rows.push_back(
        {.header = "[SOURce:]UPDate:MODE",
         .parameters = {scpi::choice("PERiod")},  // changes always take effect at the next start of a period
         .set = [](scpi::Call&) {},
         .query = [](scpi::Call& call) { call.reply.word("PER"); },
         .guarded = true});
    for (const char* what : {"acceleration", "velocity", "displacement", "force", "drive"})
        rows.push_back(predicted_row(bench, what));
    for (const char* way : {"UP", "DOWN"})
        rows.push_back({.header = std::string{"OUTPut:RAMP:"} + way, .query = [&bench](scpi::Call& call) {
                            call.reply.number(bench.state()->facts->soft_start_periods /
                                              bench.pending_orders().drive().frequency);
                        }});
    rows.push_back({.header = "OUTPut[:STATe]",
                    .parameters = {scpi::boolean()},
                    .set = [&bench](scpi::Call& call) { output(bench, call); },
                    .query =
                        [&bench](scpi::Call& call) {
                            const run::RunState s = bench.state()->state;
                            call.reply.boolean(driving(s) && s != run::RunState::ramp_down);
                        },
                    .guarded = true});
    rows.push_back({.header = "OUTPut:PROTection:TRIPped", .query = [&bench](scpi::Call& call) {
                        call.reply.boolean(bench.state()->state == run::RunState::tripped);
                    }});
    rows.push_back({.header = "OUTPut:PROTection:CAUSe",
                    .query =
                        [&bench](scpi::Call& call) {
                            const auto s = bench.state();
                            call.reply.string(s->trip ? text(*s->trip) : std::string{});
                        },
                    .without = scpi::empty_string});
    rows.push_back({.header = "OUTPut:PROTection:CLEar",
                    .set = [&bench](scpi::Call& call) { bench.order(call.session, service::ClearTrip{}); },
                    .guarded = true});
    rows.push_back(
        {.header = "OUTPut:PROTection:LEVel",
         .parameters = {scpi::number("V", 0, std::numeric_limits<double>::max())},
         .set =
             [&bench](scpi::Call& call) {
                 safety::Limits limits = bench.pending_orders().limits();
                 limits.drive.abort = call.arguments[0].number;
                 limits.drive.warn = std::min(limits.drive.warn, limits.drive.abort);
                 bench.order(call.session, service::LowerLimits{limits});
             },
         .query =
             [&bench](scpi::Call& call) { call.reply.number(bench.pending_orders().limits().drive.abort); },
         .guarded = true});
    rows.push_back({.header = "CONTrol:IDENtify[:STARt]",
                    .set = [&bench](scpi::Call& call) { bench.order(call.session, service::Identify{}); },
                    .guarded = true});
    rows.push_back({.header = "CONTrol:IDENtify:RESult",
                    .query = [&bench](scpi::Call& call) { response(bench, call); },
                    .without = scpi::nan_numbers});
    rows.push_back({.header = "CONTrol:LOOP[:STATe]",
                    .parameters = {scpi::boolean()},
                    .set =
                        [&bench](scpi::Call& call) {
                            bench.order(call.session, service::CloseLoop{call.arguments[0].on});
                        },
                    .query = [&bench](scpi::Call& call) { call.reply.boolean(bench.state()->closed_loop); },
                    .guarded = true});
    rows.push_back({.header = "CONTrol:LOOP:TOLerance",
                    .query = [](scpi::Call& call) { call.reply.number(control::kept_within); }});
    rows.push_back({.header = "CONTrol:LOOP:ERRor",
                    .query = [&bench](scpi::Call& call) { call.reply.number(loop_error(*bench.state())); }});
    rows.push_back({.header = "CONTrol:LOOP:LOCKed",
                    .query = [&bench](scpi::Call& call) { call.reply.boolean(bench.state()->locked); }});
    rows.push_back({.header = "FETCh:ACCeleration:HARMonics",
                    .query = [&bench](scpi::Call& call) { harmonics_row(bench, call); },
                    .query_parameters = {scpi::optional(scpi::integer(1, max_harmonics))},
                    .without = scpi::nan_numbers});
    return rows;
}

std::vector<Command> command_table(BenchInstrument& bench) {
    std::vector<Command> rows = drive_commands(bench);
    for (auto* part : {&shape_commands, &read_commands, &measure_commands, &sense_commands, &bench_commands})
        for (Command& row : part(bench)) rows.push_back(std::move(row));
    return scpi::with_standard_commands(std::move(rows));
}

}  // namespace shaker::instrument
