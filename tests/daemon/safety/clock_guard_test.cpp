#include <gtest/gtest.h>

#include "daemon/safety/period_guard.hpp"

namespace shaker::safety {
namespace {

HostTime at(double s) { return HostTime{std::chrono::nanoseconds{static_cast<std::int64_t>(1e9 * s)}}; }

// An accelerometer whose rate is off by `before` ppm for 30 s and by `after` from then on.
std::uint64_t warnings_of(double before, double after) {
    calibration::Timebase clock{{.dac_rate_hz = 48000, .accelerometer_rate_hz = 4000, .cameras = {}}};
    ClockGuard watch{4000};
    Warnings warnings;
    double t = 0;
    std::int64_t dac = 0;
    for (std::int64_t tick = 0; t < 60; tick += 16) {
        for (; static_cast<double>(dac) / 48000 < t; dac += 480)
            clock.add({.tick = {dac}, .heard = at(static_cast<double>(dac) / 48000)});
        t += 16 / (4000 * (1 + 1e-6 * (t < 30 ? before : after)));
        AccelBlock block;
        block.first = {tick};
        block.size = 16;
        block.arrived = at(t);
        clock.add(block);
        if (t > 10 && tick % 1600 == 0) watch.check(clock, {tick}, warnings);
    }
    return warnings[Cause::clock];
}

TEST(ClockGuardTest, ConstantErrorIsCorrectedChangeIsCounted) {
    EXPECT_EQ(warnings_of(-5000, -5000), 0U);
    EXPECT_EQ(warnings_of(0, 100), 0U);
    EXPECT_GT(warnings_of(0, 400), 0U);
    EXPECT_GT(warnings_of(3000, 2600), 0U);
}

}  // namespace
}  // namespace shaker::safety
