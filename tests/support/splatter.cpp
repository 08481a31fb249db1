#include "tests/support/splatter.hpp"

#include <cmath>
#include <complex>
#include <unsupported/Eigen/FFT>
#include <vector>

#include "drivers/drive.hpp"

namespace shaker::test {

double splatter_dB(std::span<const double> signal, double rate_hz, double above_hz) {
    const auto n = static_cast<double>(signal.size());
    std::vector<double> windowed(signal.begin(), signal.end());
    // This window's side lobes fall by 54 dB an octave: nothing of 40 Hz is left at 500 Hz above a double's
    // rounding.
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

}  // namespace shaker::test
