#pragma once
// Mixtures of normal distributions over a grid, and the interval that they cover.
#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

namespace shaker::reduction {

/// Cells of equal width in a logarithm.
struct Axis {
    double low = 0, high = 0;
    int cells = 1;
    [[nodiscard]] double width() const noexcept { return (high - low) / cells; }
    [[nodiscard]] double at(int i) const noexcept { return low + (i + 0.5) * width(); }
};

/// A normal distribution about 0 among several.
struct NormalPart {
    double weight, variance;
};
/// Half of the width that holds 95 % of the mixture. The weights need no common sum.
inline double half_width_95(std::span<const NormalPart> parts) {
    std::vector<double> scales;
    double total = 0, low = 0, high = 0;
    for (const NormalPart& p : parts) {
        scales.push_back(1 / std::sqrt(2 * p.variance));
        total += p.weight;
        high = std::max(high, 2 * std::sqrt(p.variance));
    }
    for (int i = 0; i < 40; ++i) {
        const double h = (low + high) / 2;
        double outside = 0;
        for (std::size_t k = 0; k < parts.size(); ++k) outside += parts[k].weight * std::erfc(h * scales[k]);
        (outside > 0.05 * total ? low : high) = h;
    }
    return high;
}

}  // namespace shaker::reduction
