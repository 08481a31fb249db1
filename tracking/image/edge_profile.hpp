#pragma once
// The Gaussian edge, tabulated.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace shaker::tracking {

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
