#pragma once
// RoughSurface: mu as a function of the place on the base.
#include <array>
#include <cstddef>

#include "drivers/walker/friction.hpp"

namespace shaker::walker {

/// 1 + R(x) of Roughness. Immutable.
class RoughSurface {
public:
    explicit RoughSurface(const Roughness& roughness);
    /// Factor of mu at a place on the base, m.
    [[nodiscard]] double factor(double place) const noexcept;

private:
    struct Wave {
        double number;  // rad/m
        double phase;   // rad
    };
    static constexpr std::size_t waves = 8;
    double amplitude_;  // of each wave
    std::array<Wave, waves> waves_{};
};

}  // namespace shaker::walker
