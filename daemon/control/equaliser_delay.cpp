// The delay of sensor and clocks: the response of a data sheet does not contain it. At 20 Hz, a sensor that
// is 7 ms late turns harmonic 1 by 50 degrees and harmonic 2 by 100, and corrections by the data sheet with
// them. An identified response contains it, so nothing changes then.
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>

#include "daemon/control/equaliser.hpp"

namespace shaker::control {

namespace {
constexpr double least_turn = 0.2;  // rad of harmonic 1; steps learn a smaller delay
constexpr double most_apart = 0.5;  // rad; phases of a delay are proportional to the frequency
constexpr double strong_share = 0.1, above_noise = 5;
}  // namespace

// Harmonics 1 and 2 show a delay: others are turned by it, too. `first_` stays: a step that does harm returns
// to it.
void Equaliser::measure_delay(const Block& block, double noise) {
    const Harmonics<Acceleration> predicted = plant_.motion(block.volts);
    const double strong =
        std::max(strong_share * norm(block.measured, settings_.harmonics), above_noise * noise);
    const auto seen = [&](int q) {
        return std::min(std::abs(predicted.at(q)), std::abs(block.measured.at(q))) > strong;
    };
    if (!seen(1) || !seen(2)) return;
    const auto ratio = [&](int q) { return block.measured.at(q) / predicted.at(q); };
    const double first = std::arg(ratio(1)), each = std::arg(ratio(2) / ratio(1));
    const bool late = std::min(std::abs(first), std::abs(each)) > least_turn;
    if (!late || std::abs(std::remainder(each - first, two_pi)) > most_apart) return;
    const double common = std::sqrt(std::abs(ratio(1) * ratio(2)));
    std::array<std::complex<double>, max_harmonics> factors{};
    for (int q = 1; q <= max_harmonics; ++q)
        factors.at(static_cast<std::size_t>(q - 1)) =
            seen(q) ? ratio(q) : std::polar(common, first + (q - 1) * each);
    plant_.scale(factors);
}

}  // namespace shaker::control
