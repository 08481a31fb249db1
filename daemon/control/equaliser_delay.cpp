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

Harmonics<Acceleration> turned(const Harmonics<Acceleration>& h, double lag) {
    Harmonics<Acceleration> later;
    for (int q = 1; q <= max_harmonics; ++q) later.at(q) = h.at(q) * std::polar(1.0, q * lag);
    return later;
}

// Starts Newton's method at the best of the lags that are ideal for one harmonic each. Starting from a
// weak harmonic, whose phase may be wrong, could end in a lower maximum.
double best_lag(const Harmonics<Acceleration>& wanted, const Harmonics<Acceleration>& measured) {
    Harmonics<Acceleration> product;
    for (int q = 1; q <= max_harmonics; ++q) product.at(q) = std::conj(measured.at(q)) * wanted.at(q);
    double lag = 0, most = -INFINITY;
    for (int q = 1; q <= max_harmonics; ++q) {
        if (product.at(q) == 0.0) continue;
        for (int turn = 0; turn < q; ++turn) {
            const double place = (two_pi * turn - std::arg(product.at(q))) / q;
            double fit = 0;
            for (int k = 1; k <= max_harmonics; ++k)
                fit += (product.at(k) * std::polar(1.0, k * place)).real();
            if (fit > most) most = fit, lag = place;
        }
    }
    for (int round = 0; round < 4; ++round) {  // Newton's method on sum_q Re(product_q e^{i q lag})
        double slope = 0, curve = 0;
        for (int q = 1; q <= max_harmonics; ++q) {
            const std::complex<double> c = product.at(q) * std::polar(1.0, q * lag);
            slope -= q * c.imag();
            curve -= q * q * c.real();
        }
        if (!(curve < 0)) break;
        lag -= std::clamp(slope / curve, -0.3, 0.3);
    }
    return std::remainder(lag, two_pi);
}

}  // namespace shaker::control
