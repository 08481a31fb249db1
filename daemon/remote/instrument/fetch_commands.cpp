#include <spdlog/fmt/fmt.h>

#include <variant>

#include "daemon/reduction/quantities.hpp"
#include "daemon/remote/instrument/instrument.hpp"
#include "daemon/remote/scpi/error.hpp"
#include "daemon/remote/scpi/reply.hpp"
#include "daemon/remote/scpi/session.hpp"
#include "daemon/service/published.hpp"

namespace shaker::instrument {

namespace {

using scpi::Command;

void reply_estimate(scpi::Call& call, const calibration::Estimate& e) {
    call.reply.number(e.value);
    call.reply.number(e.sigma);
}

// Replies with pairs of mean and standard error for each bin.
void cycle(scpi::Call& call, const std::vector<double>& mean, const std::vector<double>& error) {
    std::vector<double> pairs;
    pairs.reserve(2 * mean.size());
    for (std::size_t i = 0; i < mean.size(); ++i) {
        pairs.push_back(mean[i]);
        pairs.push_back(error[i]);
    }
    call.reply.numbers(pairs);
}

void no_null(scpi::Reply& reply, std::string_view source) {
    scpi::nans<2>(reply);
    reply.word(source);
}

void mirror(BenchInstrument& bench, scpi::Call& call) {
    const auto state = bench.state();
    if (!state->mirror)
        throw scpi::Error{scpi::Code::stale_data, "the newest measurement has no partner at phi + pi yet"};
    reply_estimate(call, state->mirror->drift);
    reply_estimate(call, state->mirror->common);
}

reduction::NullPhase null_of(const service::BenchState& state) {
    if (state.null) return *state.null;
    throw scpi::Error{scpi::Code::stale_data,
                      fmt::format("no two measurements at rho 0.5 enclose the null of v_D within {} rad",
                                  reduction::widest_bracket)};
}

calibration::Estimate mu_of(const service::BenchState& state) {
    const law::Fit& mu = state.fitted_mu;
    if (std::isfinite(mu.value)) return {mu.value, mu.error};
    throw scpi::Error{scpi::Code::stale_data,
                      "mu is not known: " + (mu.note.empty() ? "nothing has been measured" : mu.note)};
}

void reply(const service::Published& row, const service::BenchState& state, scpi::Reply& to) {
    const auto give = [&]<class T>(T value) {
        if constexpr (std::is_same_v<T, bool>)
            to.boolean(value);
        else if constexpr (std::is_same_v<T, std::uint64_t>)
            to.integer(static_cast<std::int64_t>(value));
        else if constexpr (std::is_same_v<T, double>)
            to.number(value);
        else
            throw scpi::Error{scpi::Code::stale_data, fmt::format("not known yet: {}", row.help)};
    };
    std::visit(give, row.value(state));
}

}  // namespace

std::vector<Command> fetch_commands(BenchInstrument& bench) {
    std::vector<Command> rows;
    rows.push_back({.header = "FETCh:DRIFt",
                    .query = [&bench](scpi::Call& call) { reply_drift(*bench.state(), call.reply); },
                    .without = reply_no_drift});
    rows.push_back({.header = "FETCh:MIRRor",
                    .query = [&bench](scpi::Call& call) { mirror(bench, call); },
                    .without = scpi::nans<4>});
    rows.push_back({.header = "FETCh:THETa",
                    .query =
                        [&bench](scpi::Call& call) {
                            reply_estimate(call, null_of(*bench.state()).theta);
                            call.reply.word("NULL");
                        },
                    .without = [](scpi::Reply& reply) { no_null(reply, "NULL"); }});
    rows.push_back({.header = "FETCh:MU",
                    .query =
                        [&bench](scpi::Call& call) {
                            const auto state = bench.state();
                            reply_estimate(call, mu_of(*state));
                            call.reply.word(state->fitted_mu.refused ? "REFUSED" : "COULOMB");
                        },
                    .without = [](scpi::Reply& reply) { no_null(reply, "COULOMB"); }});
    for (const reduction::Quantity& q : reduction::quantities)
        if (!q.header.empty())
            rows.push_back(
                {.header = std::string{q.header},
                 .query = [&bench, of = q.of](
                              scpi::Call& call) { reply_estimate(call, of(*result_of(*bench.state()))); },
                 .without = scpi::nans<2>});
    rows.push_back({.header = "FETCh:VELocity:CYCLe",
                    .query =
                        [&bench](scpi::Call& call) {
                            const auto r = result_of(*bench.state());
                            cycle(call, r->cycle.v_mps, r->cycle.v_sd_mps);
                        },
                    .without = scpi::nan_numbers});
    rows.push_back({.header = "FETCh:POSition:CYCLe",
                    .query =
                        [&bench](scpi::Call& call) {
                            const auto r = result_of(*bench.state());
                            cycle(call, r->cycle.x_m, r->cycle.x_sd_m);
                        },
                    .without = scpi::nan_numbers});
    rows.push_back(
        {.header = "FETCh:WALKer:POSition",
         .query =
             [&bench](scpi::Call& call) {
                 const auto s = bench.state();
                 if (!s->walker)
                     throw scpi::Error{scpi::Code::stale_data, "no recent picture shows the walker"};
                 call.reply.number(s->walker->x_m);
                 call.reply.number(s->walker->edge_m);
             },
         .without = scpi::nans<2>});
    return rows;
}

std::vector<scpi::Command> published_commands(BenchInstrument& bench) {
    std::vector<scpi::Command> rows;
    for (const service::Published& row : service::published_quantities())
        if (row.header != nullptr)
            rows.push_back({.header = row.header, .query = [&bench, &row](scpi::Call& call) {
                                reply(row, *bench.state(), call.reply);
                            }});
    return rows;
}

}  // namespace shaker::instrument
