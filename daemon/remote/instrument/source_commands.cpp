#include <algorithm>
#include <cctype>

#include "daemon/remote/instrument/commands.hpp"
#include "daemon/remote/scpi/error.hpp"
#include "daemon/remote/scpi/reply.hpp"
#include "daemon/remote/scpi/session.hpp"
#include "drivers/drive_limits.hpp"

namespace shaker::instrument {

namespace {

using scpi::Command;

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

}  // namespace

std::vector<Command> source_commands(BenchInstrument& bench) {
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
    return rows;
}

}  // namespace shaker::instrument
