#pragma once
// Blurred edges as pixels show them, from a table.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace shaker::tracking {

/// An edge at one pixel: the share of the bright side, and its derivatives by the distance and by the blur.
struct EdgeAt {
    double step, slope, by_blur;
};

/// Weight of a pixel `distance` px from the outline: 1 near it, and 0 from `reach` px on. It falls as the
/// integral of a hat of two pixels' width: the weights of all pixels add up to the same wherever the outline
/// lies between them.
inline double faded(double distance, double reach) noexcept {
    const double t = std::clamp(0.5 * (reach - std::abs(distance)), 0.0, 1.0);
    return t < 0.5 ? 2 * t * t : 1 - 2 * (1 - t) * (1 - t);
}

/// Phi(t), the Gaussian distribution function, and its density phi(t), interpolated from a table. Error below
/// 2e-6.
class EdgeProfile {
public:
    struct Value {
        double step, slope;
    };
    static constexpr double limit = 5.0;

    static Value at(double t) noexcept {
        const double at = (std::max(std::min(t, limit), -limit) + limit) * per_unit;  // without branches
        const auto i = std::min(static_cast<std::size_t>(at), size - 2);
        const double f = at - static_cast<double>(i);
        const Value &a = table()[i], &b = table()[i + 1];
        const double rise = b.step - a.step, from = a.slope / per_unit - rise, to = rise - b.slope / per_unit;
        return {a.step + f * rise + f * (1 - f) * ((1 - f) * from + f * to),
                a.slope + f * (b.slope - a.slope)};
    }

    /// A pixel `distance` px inside an edge of this standard deviation, px, which includes the pixel's own
    /// width. An edge that crosses pixels at all angles, as the rim of a disc does.
    static EdgeAt round(double distance, double blur) noexcept {
        const double t = distance / blur;
        const auto [step, slope] = at(t);
        return {step, slope / blur, -slope / blur * t};
    }
    /// The same for an edge along a row or column of pixels: the mean over a pixel of an edge that the lens
    /// has blurred. A sharp one is straight across its pixel and not Gaussian.
    static EdgeAt upright(double distance, double blur) noexcept {
        constexpr double pixel = 1.0 / 12, sharpest = 0.05;  // variance of a pixel's width; px
        const double lens = std::sqrt(std::max(blur * blur - pixel, sharpest * sharpest));
        const double upper = (distance + 0.5) / lens, lower = (distance - 0.5) / lens;
        const auto [step_up, density_up] = at(upper);
        const auto [step_low, density_low] = at(lower);
        const double change = density_up - density_low;
        return {lens * (upper * step_up - lower * step_low + change), step_up - step_low,
                change * blur / lens};
    }

private:
    static constexpr double per_unit = 16;
    static constexpr std::size_t size = static_cast<std::size_t>(2 * limit * per_unit) + 1;
    static const std::array<Value, size>& table() noexcept {
        static const std::array<Value, size> values = [] {
            std::array<Value, size> v{};
            for (std::size_t i = 0; i < size; ++i) {
                const double t = static_cast<double>(i) / per_unit - limit;
                v[i] = {0.5 * std::erfc(-t / std::numbers::sqrt2),
                        std::exp(-0.5 * t * t) / std::sqrt(2 * std::numbers::pi)};
            }
            return v;
        }();
        return values;
    }
};

}  // namespace shaker::tracking
