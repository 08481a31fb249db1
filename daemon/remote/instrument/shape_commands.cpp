// Shape of one period of the drive: sinusoid, biharmonic or with overtones.
#include <array>
#include <cmath>
#include <vector>

#include "daemon/remote/instrument/commands.hpp"
#include "daemon/remote/scpi/error.hpp"
#include "drivers/drive_limits.hpp"

namespace shaker::instrument {

namespace {

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
