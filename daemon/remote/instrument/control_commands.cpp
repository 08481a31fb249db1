#include <algorithm>
#include <cmath>

#include "daemon/control/equaliser.hpp"
#include "daemon/remote/instrument/instrument.hpp"
#include "daemon/remote/scpi/error.hpp"
#include "daemon/remote/scpi/reply.hpp"
#include "daemon/remote/scpi/session.hpp"

namespace shaker::instrument {

namespace {

using scpi::Command;

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

}  // namespace

std::vector<Command> control_commands(BenchInstrument& bench) {
    std::vector<Command> rows;
    rows.push_back(command_of(bench, "identify"));
    rows.push_back({.header = "CONTrol:IDENtify:RESult",
                    .query = [&bench](scpi::Call& call) { response(bench, call); },
                    .without = scpi::nan_numbers});
    rows.push_back(
        command_of(bench, "loop", one([&bench] { return bench.pending_orders().settings().closed_loop; })));
    rows.push_back({.header = "CONTrol:LOOP:TOLerance", .query = one([] { return control::kept_within; })});
    rows.push_back(asks(bench, "CONTrol:LOOP:ERRor", loop_error));
    rows.push_back({.header = "FETCh:ACCeleration:HARMonics",
                    .query = [&bench](scpi::Call& call) { harmonics_row(bench, call); },
                    .query_parameters = {scpi::optional(scpi::integer(1, max_harmonics))},
                    .without = scpi::nan_numbers});
    return rows;
}

}  // namespace shaker::instrument
