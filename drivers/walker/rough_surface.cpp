#include "drivers/walker/rough_surface.hpp"

#include <cmath>
#include <numbers>
#include <random>

namespace shaker::walker {

RoughSurface::RoughSurface(const Roughness& roughness)
    : amplitude_{roughness.share * std::sqrt(2.0 / waves)} {
    std::mt19937_64 random{roughness.seed};
    for (std::size_t i = 0; i < waves; ++i) {
        const double octave = 2 * static_cast<double>(i) / (waves - 1.0) - 1;  // -1..1
        waves_[i].number = 2 * std::numbers::pi * std::exp2(octave) / roughness.length;
        waves_[i].phase = 2 * std::numbers::pi * static_cast<double>(random() >> 11) * 0x1p-53;
    }
}

double RoughSurface::factor(double place) const noexcept {
    if (amplitude_ == 0) return 1;
    double sum = 0;
    for (const Wave& w : waves_) sum += std::cos(w.number * place + w.phase);
    return 1 + amplitude_ * sum;
}

}  // namespace shaker::walker
