#include <gtest/gtest.h>

#include <cstdint>

#include "calibration/clocks/clock_tracker.hpp"

namespace shaker::calibration {
namespace {

using std::chrono::nanoseconds;

// Nanoseconds since 1970 and months of ticks: numbers for which a double would lose 256 ns.
constexpr DacTick tick0{1'000'000'000'000};
constexpr HostTime time0{nanoseconds{1'700'000'000'000'000'001}};

TEST(ClockMapTest, IsExactAtItsOwnPointForLargeNumbers) {
    const ClockMap<struct DacClock> map{tick0, time0, 1e9 / 48000};
    EXPECT_EQ(map.at(tick0), time0);
    EXPECT_EQ(map.at(DacTick{tick0.n + 48000}), time0 + nanoseconds{1'000'000'000});
    EXPECT_EQ(map.at(DacTick{tick0.n - 480000}), time0 - nanoseconds{10'000'000'000});
}

TEST(ClockMapTest, InverseReturnsTickAndFraction) {
    const ClockMap<struct CameraClock> map{{tick0.n}, time0, 1e6 * (1 + 37.5e-6)};
    for (const std::int64_t n : {-100'001, -1, 0, 1, 99'999}) {
        const auto instant = map.at(map.at(CameraTick{tick0.n + n}));
        // Host time is rounded to a nanosecond, a millionth of this tick; at most half of it is off.
        const double off = static_cast<double>(instant.tick.n - tick0.n - n) + instant.fraction;
        EXPECT_NEAR(off, 0, 0.51e-6);
        EXPECT_GE(instant.fraction, 0);
        EXPECT_LT(instant.fraction, 1);
    }
    const auto half = map.at(map.at(TickInstant<struct CameraClock>{{tick0.n - 5}, 0.5}));
    EXPECT_EQ(half.tick.n, tick0.n - 5);
    EXPECT_NEAR(half.fraction, 0.5, 1e-6);
}

TEST(ClockMapTest, ErrorsGrowWithDistanceFromMiddle) {
    const ClockMap<struct DacClock> map{tick0, time0, 1e9 / 48000, Seconds{3e-7}, 4e-8};
    EXPECT_DOUBLE_EQ(map.sigma_at(tick0).count(), 3e-7);
    EXPECT_NEAR(map.sigma_at(DacTick{tick0.n + 480000}).count(), 5e-7, 1e-15);  // 10 s: 0.3 and 0.4 us
    EXPECT_EQ(map.sigma_at(DacTick{tick0.n - 480000}), map.sigma_at(DacTick{tick0.n + 480000}));
}

}  // namespace
}  // namespace shaker::calibration
