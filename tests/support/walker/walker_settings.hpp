#pragma once
// Settings of walkers for tests: the drives of the paper, and random drives.
#include <random>

#include "drivers/walker/walker_law.hpp"

namespace shaker {

/// The paper's walker (mu = 0.113, 20 Hz) on a biharmonic drive; gamma in units of g.
inline walker::WalkerSetting paper_setting(double gamma_in_g, double phi, double rho = 0.5) {
    walker::WalkerSetting s;
    s.base = harmonics(Drive{.gamma = gamma_in_g * paper_g, .rho = rho, .phi = phi});
    return s;
}

/// A number in [low, high) from a fixed stream, the same with every C++ library.
inline double uniform(std::mt19937_64& random, double low, double high) {
    return low + (high - low) * static_cast<double>(random() >> 11) * 0x1p-53;
}

/// Harmonics up to `order` with random phases and amplitudes that add up to `sum`; every `step`-th from 1.
inline Harmonics<Acceleration> random_harmonics(std::mt19937_64& random, int order, double sum,
                                                int step = 1) {
    Harmonics<Acceleration> h;
    double total = 0;
    for (int q = 1; q <= order; q += step) {
        h.at(q) = std::polar(uniform(random, 0.05, 1), uniform(random, 0, two_pi));
        total += std::abs(h.at(q));
    }
    for (auto& a : h.a) a *= sum / total;
    return h;
}

}  // namespace shaker
