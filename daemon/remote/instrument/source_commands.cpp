#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <vector>

#include "daemon/remote/instrument/instrument.hpp"
#include "daemon/remote/scpi/error.hpp"
#include "daemon/remote/scpi/reply.hpp"
#include "daemon/remote/scpi/session.hpp"
#include "drivers/drive.hpp"

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
            .query = one([&bench, member] { return bench.pending_orders().drive().*member; }),
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

using scpi::Command;

enum Shape { sinusoid, biharmonic, multiharmonic };  // in the order of FUNCtion's words

Shape shape_of(const Drive& drive) {
    if (!drive.biharmonic()) return multiharmonic;
    return drive.rho == 1 ? sinusoid : biharmonic;
}

// SINusoid: all in harmonic 1. BIHarmonic: the paper's rho = 1/2, unless there is a second harmonic already.
void set_shape(BenchInstrument& bench, scpi::Call& call) {
    Drive drive = bench.pending_orders().drive();
    const auto wanted = static_cast<Shape>(call.arguments[0].word);
    if (wanted == shape_of(drive)) return;
    if (wanted == multiharmonic)
        throw scpi::Error{scpi::Code::settings_conflict,
                          "no overtone is set; set one with HARMonic<3..8>:AMPLitude"};
    drive.overtones = {};
    if (wanted == sinusoid)
        drive.rho = 1;
    else if (drive.rho == 1)
        drive.rho = Drive{}.rho;
    bench.order(call.session, service::SetDrive{drive});
}

int harmonic_of(const scpi::Call& call) {
    const int q = call.suffixes[0];
    if (q > most_driven)
        throw scpi::Error{scpi::Code::out_of_range,
                          "harmonic " + std::to_string(q) + ", allowed 1 to " + std::to_string(most_driven)};
    return q;
}

/// Complex amplitude of a harmonic as a share of gamma.
std::complex<double> share_of(const Drive& drive, int q) {
    if (q == 1) return drive.rho;
    if (q == 2) return std::polar(1 - drive.rho, drive.phi);
    return q > most_driven ? 0 : drive.overtones.at(static_cast<std::size_t>(q - 3));
}

void set_amplitude(BenchInstrument& bench, scpi::Call& call) {
    Drive drive = bench.pending_orders().drive();
    const int q = harmonic_of(call);
    const double share = call.arguments[0].number;
    if (q <= 2)
        drive.rho = q == 1 ? share : 1 - share;
    else
        drive.overtones.at(static_cast<std::size_t>(q - 3)) = std::polar(share, std::arg(share_of(drive, q)));
    bench.order(call.session, service::SetDrive{drive});
}

void set_phase(BenchInstrument& bench, scpi::Call& call) {
    Drive drive = bench.pending_orders().drive();
    const int q = harmonic_of(call);
    const double phase = call.arguments[0].number;
    if (q == 1 && phase != 0)
        throw scpi::Error{scpi::Code::settings_conflict,
                          "harmonic 1 has phase 0 by definition; set the phase of another harmonic"};
    if (q == 1) return;
    if (q > 2 && share_of(drive, q) == 0.0)
        throw scpi::Error{scpi::Code::settings_conflict,
                          "harmonic " + std::to_string(q) + " has no amplitude; set it first"};
    if (q == 2)
        drive.phi = phase;
    else
        drive.overtones.at(static_cast<std::size_t>(q - 3)) = std::polar(std::abs(share_of(drive, q)), phase);
    bench.order(call.session, service::SetDrive{drive});
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

std::vector<Command> shape_commands(BenchInstrument& bench) {
    const DriveLimits& l = drive_limits;
    std::vector<Command> rows;
    rows.push_back({.header = "[SOURce:]FUNCtion[:SHAPe]",
                    .parameters = {scpi::choice("SINusoid|BIHarmonic|MULTiharmonic")},
                    .set = [&bench](scpi::Call& call) { set_shape(bench, call); },
                    .query =
                        [&bench](scpi::Call& call) {
                            constexpr std::array words{"SIN", "BIH", "MULT"};
                            call.reply.word(words.at(shape_of(bench.pending_orders().drive())));
                        },
                    .guarded = true});
    rows.push_back({.header = "[SOURce:]HARMonic<1..16>:AMPLitude",
                    .parameters = {scpi::number("", l.share.min, l.share.max)},
                    .set = [&bench](scpi::Call& call) { set_amplitude(bench, call); },
                    .query =
                        [&bench](scpi::Call& call) {
                            call.reply.number(
                                std::abs(share_of(bench.pending_orders().drive(), call.suffixes[0])));
                        },
                    .guarded = true});
    rows.push_back({.header = "[SOURce:]HARMonic<1..16>:PHASe",
                    .parameters = {scpi::number("RAD", l.phi.min, l.phi.max)},
                    .set = [&bench](scpi::Call& call) { set_phase(bench, call); },
                    .query =
                        [&bench](scpi::Call& call) {
                            const std::complex<double> share =
                                share_of(bench.pending_orders().drive(), call.suffixes[0]);
                            call.reply.number(call.suffixes[0] == 2 ? bench.pending_orders().drive().phi
                                                                    : std::arg(share));
                        },
                    .guarded = true});
    return rows;
}

}  // namespace shaker::instrument
