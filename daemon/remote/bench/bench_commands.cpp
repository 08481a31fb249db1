#include <cmath>
#include <limits>

#include "daemon/remote/bench/commands.hpp"
#include "daemon/remote/scpi/error.hpp"
#include "daemon/remote/scpi/reply.hpp"
#include "daemon/remote/scpi/session.hpp"

namespace shaker {

namespace {

using scpi::Call;
using scpi::Command;

/// LIMit:<quantity>:WARN and :ABORt. `scale`: SI units a unit of the limits.
void limit_rows(BenchInstrument& bench, std::vector<Command>& rows, const std::string& quantity,
                const char* unit, Level Limits::*level) {
    const auto row = [&](const char* name, double Level::*end) {
        rows.push_back({.header = "LIMit:" + quantity + ":" + name,
                        .parameters = {scpi::number(unit, 0, std::numeric_limits<double>::max())},
                        .set =
                            [&bench, level, end](Call& call) {
                                Limits limits = bench.book().limits();
                                (limits.*level).*end = call.arguments[0].number;
                                Level& l = limits.*level;
                                l.warn = std::min(l.warn, l.abort);
                                bench.order(call.session, LowerLimits{limits});
                            },
                        .query = [&bench, level, end](
                                     Call& call) { call.reply.number((bench.book().limits().*level).*end); },
                        .guarded = true});
    };
    row("WARN", &Level::warn);
    row("ABORt", &Level::abort);
}

void losses(BenchInstrument& bench, Call& call) {
    const LostState l = bench.state()->lost;
    for (const std::uint64_t n : {l.plays, l.changes, l.blocks, l.frames, l.trips, l.samples_clamped})
        call.reply.integer(static_cast<std::int64_t>(n));
}

}  // namespace

std::vector<Command> bench_commands(BenchInstrument& bench) {
    std::vector<Command> rows;
    limit_rows(bench, rows, "ACCeleration", "M/S2", &Limits::acceleration);
    limit_rows(bench, rows, "VELocity", "M/S", &Limits::velocity);
    limit_rows(bench, rows, "DISPlacement", "M", &Limits::displacement);
    limit_rows(bench, rows, "DRIVe", "V", &Limits::drive);
    limit_rows(bench, rows, "TRANsverse", "", &Limits::transverse);
    rows.push_back(
        {.header = "LIMit:WALKer:EDGE",
         .parameters = {scpi::number("M", 0, 1)},
         .set =
             [&bench](Call& call) {
                 Limits limits = bench.book().limits();
                 limits.edge_mm = 1e3 * call.arguments[0].number;
                 bench.order(call.session, LowerLimits{limits});
             },
         .query = [&bench](Call& call) { call.reply.number(1e-3 * bench.book().limits().edge_mm); },
         .guarded = true});
    rows.push_back({.header = "LIMit:OPEN:STATe", .query = [&bench](Call& call) {
                        const auto which = static_cast<std::size_t>(Cause::sensor_open);
                        call.reply.boolean(bench.book().limits().detectors[which]);
                    }});
    rows.push_back({.header = "SYSTem:STATe",
                    .query = [&bench](Call& call) { call.reply.string(name(bench.state()->state)); }});
    rows.push_back({.header = "SYSTem:CLOCk",
                    .query = [&bench](Call& call) { call.reply.number(bench.state()->now_s); }});
    rows.push_back({.header = "SYSTem:HEALth", .query = [&bench](Call& call) {
                        const auto state = bench.state();
                        for (const DeviceReport& d : state->devices) {
                            call.reply.string(d.device);
                            call.reply.integer(static_cast<std::int64_t>(d.counts.taken));
                            call.reply.integer(static_cast<std::int64_t>(d.counts.lost));
                            call.reply.integer(static_cast<std::int64_t>(d.counts.incidents));
                        }
                    }});
    rows.push_back(
        {.header = "DIAGnostic:RT", .query = [&bench](Call& call) {
             const auto s = bench.state();
             const LostState& l = s->lost;
             call.reply.integer(
                 s->devices.empty() ? 0 : static_cast<std::int64_t>(s->devices.front().counts.incidents));
             call.reply.number(1e6 * s->jitter.worst_s);
             call.reply.number(1e6 * PeriodJitter::quantile(s->jitter, 0.99));
             call.reply.integer(
                 static_cast<std::int64_t>(l.plays + l.changes + l.blocks + l.frames + l.trips));
         }});
    rows.push_back({.header = "DIAGnostic:LOSSes", .query = [&bench](Call& call) { losses(bench, call); }});
    return rows;
}

}  // namespace shaker
