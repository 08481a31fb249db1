#include "tests/support/tracking/splatter.hpp"

#include <cmath>
#include <complex>
#include <cstdint>
#include <stdexcept>
#include <unsupported/Eigen/FFT>

namespace shaker::test {
namespace {

constexpr double rate = 48000;
constexpr double limit_V = 10;
constexpr std::int64_t period = 2400;
constexpr std::int64_t half = 1 << 15;  // samples on either side of the middle
constexpr std::int64_t change_at = 100 * period;

}  // namespace

double splatter_db(std::span<const double> signal, double rate_hz, double above_hz) {
    const auto n = static_cast<double>(signal.size());
    std::vector<double> windowed(signal.begin(), signal.end());
    // This window's side lobes fall by 54 dB an octave: nothing of 40 Hz is left at 500 Hz but rounding.
    for (std::size_t i = 0; i < windowed.size(); ++i)
        windowed[i] *= std::pow(std::sin(0.5 * two_pi * static_cast<double>(i) / n), 8);
    Eigen::FFT<double> fft;
    std::vector<std::complex<double>> lines;
    fft.fwd(lines, windowed);
    double all = 0;
    double high = 0;
    for (std::size_t k = 0; k <= lines.size() / 2; ++k) {
        const double energy = std::norm(lines[k]);
        all += energy;
        if (static_cast<double>(k) * rate_hz / n > above_hz) high += energy;
    }
    return 10 * std::log10(high / all);
}

DriveCommand biharmonic(double gamma, double phi, double frequency) {
    DriveCommand c;
    c.volts.at(1) = 0.5 * gamma;
    c.volts.at(2) = std::polar(0.5 * gamma, phi);
    c.frequency = frequency;
    return c;
}

std::vector<double> around_ramp(const DriveCommand& from, const DriveCommand& to) {
    Synthesiser synth{rate, from.frequency, limit_V};
    std::vector<double> volts(2 * half);
    synth.set(from);
    synth.skip(change_at + period / 2 - half);
    synth.fill(std::span{volts}.first(half - period / 2));
    synth.set(to);
    synth.fill(std::span{volts}.last(half + period / 2));
    if (synth.change() == nullptr || synth.change()->first.n != change_at)
        throw std::logic_error{"the ramp is not in the middle of the signal"};
    return volts;
}

std::vector<double> around_jump(const DriveCommand& from, const DriveCommand& to) {
    Synthesiser before{rate, from.frequency, limit_V};
    Synthesiser after{rate, to.frequency, limit_V};
    std::vector<double> volts(2 * half);
    before.set(from);
    before.skip(change_at - half);
    before.fill(std::span{volts}.first(half));
    after.set(to);
    after.skip(change_at);
    after.fill(std::span{volts}.last(half));
    return volts;
}

}  // namespace shaker::test
