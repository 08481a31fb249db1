#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <limits>
#include <vector>

#include "daemon/remote/instrument/instrument.hpp"
#include "daemon/remote/scpi/error.hpp"
#include "daemon/remote/scpi/reply.hpp"
#include "daemon/remote/scpi/session.hpp"

namespace shaker::instrument {

namespace {

using scpi::Command;

/// LIMit:<quantity>:WARN and :ABORt.
void limit_rows(BenchInstrument& bench, std::vector<Command>& rows, const safety::LevelRow& quantity) {
    const auto row = [&, level = quantity.level](const char* name, double safety::Level::*end) {
        rows.push_back(
            {.header = fmt::format("LIMit:{}:{}", quantity.scpi_name, name),
             .parameters = {scpi::number(quantity.scpi_unit, 0, std::numeric_limits<double>::max())},
             .set =
                 [&bench, level, end](scpi::Call& call) {
                     bench.order(call.session, service::LowerLimit{{level, end}, call.arguments[0].number});
                 },
             .query = one([&bench, level, end] { return (bench.pending_orders().limits().*level).*end; }),
             .guarded = true});
    };
    row("WARN", &safety::Level::warn);
    row("ABORt", &safety::Level::abort);
}

void no_device(scpi::Reply& reply) {
    reply.string("");
    for (int i = 0; i < 3; ++i) reply.integer(0);
}

void real_time_counts(const std::vector<acquisition::RealTimeGrant>& grants, scpi::Reply& reply) {
    reply.string("real time");
    reply.integer(std::ssize(grants));
    reply.integer(std::ranges::count_if(
        grants, [](const acquisition::RealTimeGrant& g) { return !g.refused.empty(); }));
    reply.integer(0);
}

// The refusals of the operating system.
void refusals(const std::vector<acquisition::RealTimeGrant>& grants, scpi::Reply& reply) {
    bool any = false;
    for (const acquisition::RealTimeGrant& g : grants) {
        if (g.refused.empty()) continue;
        reply.string(g.refused);
        any = true;
    }
    if (!any) reply.string("");
}

void losses(BenchInstrument& bench, scpi::Call& call) {
    const service::LostState l = bench.state()->lost;
    for (const std::uint64_t n : {l.plays, l.changes, l.blocks, l.frames, l.trips, l.samples_clamped})
        call.reply.integer(static_cast<std::int64_t>(n));
}

}  // namespace

std::vector<Command> bench_commands(BenchInstrument& bench) {
    std::vector<Command> rows;
    for (const safety::LevelRow& quantity : safety::level_rows) limit_rows(bench, rows, quantity);
    rows.push_back(
        {.header = "LIMit:WALKer:EDGE",
         .parameters = {scpi::number("M", 0, 1)},
         .set =
             [&bench](scpi::Call& call) {
                 bench.order(call.session, service::LowerLimit{{}, 1e3 * call.arguments[0].number});
             },
         .query = one([&bench] { return 1e-3 * bench.pending_orders().limits().edge_mm; }),
         .guarded = true});
    constexpr auto open = static_cast<std::size_t>(safety::Cause::sensor_open);
    rows.push_back({.header = "LIMit:OPEN:STATe",
                    .query = one([&bench] { return bench.pending_orders().limits().detectors.test(open); })});
    rows.push_back(asks(bench, "SYSTem:STATe", [](const auto& s) { return name(s.state); }));
    rows.push_back({.header = "SYSTem:HEALth",
                    .query =
                        [&bench](scpi::Call& call) {
                            const auto state = bench.state();
                            if (state->devices.empty()) no_device(call.reply);
                            for (const DeviceReport& d : state->devices) {
                                call.reply.string(d.device);
                                call.reply.integer(static_cast<std::int64_t>(d.counts.taken));
                                call.reply.integer(static_cast<std::int64_t>(d.counts.lost));
                                call.reply.integer(static_cast<std::int64_t>(d.counts.incidents));
                            }
                            real_time_counts(state->real_time, call.reply);
                        },
                    .without = no_device});
    rows.push_back({.header = "SYSTem:HEALth:RTIMe",
                    .query = [&bench](scpi::Call& call) { refusals(bench.state()->real_time, call.reply); },
                    .without = scpi::empty_string});
    rows.push_back(asks(bench, "SYSTem:HEALth:CONTact",
                        [](const auto& s) { return s.contact ? service::word_of(*s.contact) : ""; }));
    rows.push_back(
        {.header = "DIAGnostic:RT", .query = [&bench](scpi::Call& call) {
             const auto s = bench.state();
             const service::LostState& l = s->lost;
             call.reply.integer(
                 s->devices.empty() ? 0 : static_cast<std::int64_t>(s->devices.front().counts.incidents));
             call.reply.number(1e6 * s->jitter.worst_s);
             call.reply.number(1e6 * acquisition::PeriodJitter::quantile(s->jitter, 0.99));
             call.reply.integer(
                 static_cast<std::int64_t>(l.plays + l.changes + l.blocks + l.frames + l.trips));
         }});
    rows.push_back(
        {.header = "DIAGnostic:LOSSes", .query = [&bench](scpi::Call& call) { losses(bench, call); }});
    return rows;
}

}  // namespace shaker::instrument
