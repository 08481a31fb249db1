#include <spdlog/fmt/fmt.h>

#include <array>
#include <cmath>

#include "daemon/remote/instrument/commands.hpp"
#include "daemon/remote/scpi/data/error.hpp"
#include "daemon/remote/scpi/data/reply.hpp"
#include "daemon/remote/scpi/session.hpp"
#include "daemon/run/run_settings.hpp"
#include "drivers/drive_limits.hpp"

namespace shaker::instrument {

namespace {

using scpi::Call;
using scpi::Code;
using scpi::Command;
using scpi::Error;

void estimate(scpi::Call& call, const calibration::Estimate& e) {
    call.reply.number(e.value);
    call.reply.number(e.sigma);
}

/// Query of one estimate of the newest measurement: value, standard error.
Command estimate_row(BenchInstrument& bench, const char* header,
                     calibration::Estimate reduction::Reduction::*member) {
    return {
        .header = header,
        .query = [&bench, member](scpi::Call& call) { estimate(call, (*result_of(*bench.state())).*member); },
        .without = scpi::nans<2>};
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

void record(BenchInstrument& bench, scpi::Call& call, bool on, std::string name) {
    const auto state = bench.state();
    bench.order(call.session, service::Record{on, std::move(name), state->pictures});
}

void mirror(BenchInstrument& bench, scpi::Call& call) {
    const auto state = bench.state();
    if (!state->mirror)
        throw scpi::Error{scpi::Code::stale_data, "the newest measurement has no partner at phi + pi yet"};
    estimate(call, state->mirror->drift);
    estimate(call, state->mirror->common);
}

reduction::NullPhase null_of(const service::BenchState& state) {
    if (state.null) return *state.null;
    throw scpi::Error{scpi::Code::stale_data,
                      fmt::format("no two measurements at rho 0.5 enclose the null of v_D within {} rad",
                                  reduction::widest_bracket)};
}

void keep_pictures(BenchInstrument& bench, scpi::Call& call) {
    const auto state = bench.state();
    bench.order(call.session, service::Record{state->record, state->record_name,
                                              static_cast<recorded::KeptPictures>(call.arguments[0].word)});
}

}  // namespace

std::vector<Command> measure_commands(BenchInstrument& bench) {
    std::vector<Command> rows;
    rows.push_back({.header = "FETCh:DRIFt",
                    .query = [&bench](scpi::Call& call) { tell_drift(*bench.state(), call.reply); },
                    .without = tell_no_drift});
    rows.push_back({.header = "FETCh:MIRRor",
                    .query = [&bench](scpi::Call& call) { mirror(bench, call); },
                    .without = scpi::nans<4>});
    rows.push_back({.header = "FETCh:THETa",
                    .query =
                        [&bench](scpi::Call& call) {
                            estimate(call, null_of(*bench.state()).theta);
                            call.reply.word("NULL");
                        },
                    .without = [](scpi::Reply& reply) { no_null(reply, "NULL"); }});
    rows.push_back({.header = "FETCh:MU",
                    .query =
                        [&bench](scpi::Call& call) {
                            estimate(call, null_of(*bench.state()).mu);
                            call.reply.word("COULOMB");
                        },
                    .without = [](scpi::Reply& reply) { no_null(reply, "COULOMB"); }});
    rows.push_back({.header = "FETCh:STEady",
                    .query = [&bench](scpi::Call& call) { call.reply.boolean(bench.state()->measuring); }});
    rows.push_back({.header = "AVERage:SETTle",
                    .parameters = {scpi::or_word("AUTO", scpi::integer(1, most_settle_periods))},
                    .set =
                        [&bench](scpi::Call& call) {
                            const scpi::Argument& a = call.arguments[0];
                            bench.settle = a.word == 0 ? 0 : static_cast<int>(a.number);
                        },
                    .query =
                        [&bench](scpi::Call& call) {
                            const int settle = bench.next().settle;
                            if (settle == 0) return call.reply.word("AUTO");
                            call.reply.integer(settle);
                        },
                    .guarded = true});
    rows.push_back(estimate_row(bench, "FETCh:EFFiciency", &reduction::Reduction::efficiency));
    rows.push_back(estimate_row(bench, "FETCh:ACCeleration:GAMMa", &reduction::Reduction::gamma));
    rows.push_back(estimate_row(bench, "FETCh:ACCeleration:PHASe", &reduction::Reduction::phi));
    rows.push_back({.header = "FETCh:ACCeleration:RESidual", .query = [&bench](scpi::Call& call) {
                        const auto s = bench.state();
                        if (!s->base)
                            throw scpi::Error{scpi::Code::stale_data, "no period has been measured yet"};
                        call.reply.number(s->base->residual);
                    }});
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
    rows.push_back({.header = "FETCh:WALKer:POSition",
                    .query =
                        [&bench](scpi::Call& call) {
                            const auto s = bench.state();
                            if (!s->walker)
                                throw scpi::Error{scpi::Code::stale_data,
                                                  "the walker has not been found in any picture yet"};
                            call.reply.number(s->walker->x_m);
                            call.reply.number(s->walker->edge_m);
                        },
                    .without = scpi::nans<2>});
    rows.push_back(
        {.header = "AVERage:PERiods",
         .parameters = {scpi::integer(2, most_periods, run::RunOptions{}.periods)},
         .set = [&bench](scpi::Call& call) { bench.periods = static_cast<int>(call.arguments[0].number); },
         .query = [&bench](scpi::Call& call) { call.reply.integer(bench.next().periods); },
         .guarded = true});
    rows.push_back({.header = "RECord[:STATe]",
                    .parameters = {scpi::boolean(), scpi::optional(scpi::string(64))},
                    .set =
                        [&bench](scpi::Call& call) {
                            const auto a = call.arguments;
                            record(bench, call, a[0].on, a[1].given ? std::string{a[1].text} : std::string{});
                        },
                    .query = [&bench](scpi::Call& call) { call.reply.boolean(bench.state()->record); },
                    .guarded = true});
    rows.push_back({.header = "RECord:NOTE",
                    .parameters = {scpi::string(service::Remark::longest)},
                    .set =
                        [&bench](scpi::Call& call) {
                            bench.order(call.session, service::Remark{std::string{call.arguments[0].text}});
                        },
                    .guarded = true});
    rows.push_back({.header = "RECord:NAME",
                    .query = [&bench](scpi::Call& call) { call.reply.string(bench.state()->recording.name); },
                    .without = scpi::empty_string});
    rows.push_back({.header = "RECord:RAW:CAMera",
                    .parameters = {scpi::choice("OFF|REGion|FULL")},
                    .set = [&bench](scpi::Call& call) { keep_pictures(bench, call); },
                    .query =
                        [&bench](scpi::Call& call) {
                            constexpr std::array words{"OFF", "REG", "FULL"};
                            call.reply.word(words.at(static_cast<std::size_t>(bench.state()->pictures)));
                        },
                    .guarded = true});
    return rows;
}

}  // namespace shaker::instrument
