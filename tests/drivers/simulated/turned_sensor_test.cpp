#include <gtest/gtest.h>

#include <cmath>

#include "drivers/simulated/sensor.hpp"

namespace shaker::simulated {
namespace {

Scene turned_scene() {
    Scene s = paper_scene();
    s.accelerometer.attitudes = "+x -x +y+z";
    s.accelerometer.held_within_deg = 0;
    return s;
}

TEST(TurnedSensorTest, HoldsEachAttitudeForItsTime) {
    const TurnedSensor sensor{turned_scene()};
    ASSERT_TRUE(sensor.turned());
    const auto expect = [&](double from, double to, const std::array<double, 3>& up) {
        for (const double t : {from + 1e-6, (from + to) / 2, to - 1e-6})
            for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(sensor.force(t)[k], 9.8 * up[k], 1e-4) << t;
    };
    expect(-1, 3, {0, 0, 1});
    expect(4, 7, {1, 0, 0});
    expect(8, 11, {-1, 0, 0});
    expect(12, 1000, {0, std::sqrt(0.5), std::sqrt(0.5)});
}

TEST(TurnedSensorTest, KeepsItsLengthOnTheWay) {
    const TurnedSensor sensor{turned_scene()};
    std::array<double, 3> before = sensor.force(0);
    for (double t = 0; t < 14; t += 1e-3) {
        const auto f = sensor.force(t);
        EXPECT_NEAR(std::hypot(f[0], f[1], f[2]), 9.8, 1e-12) << t;
        EXPECT_LT(std::hypot(f[0] - before[0], f[1] - before[1], f[2] - before[2]), 0.1) << t;
        before = f;
    }
}

TEST(TurnedSensorTest, SceneWithoutAttitudesLeavesItOnTheBase) {
    EXPECT_FALSE(TurnedSensor{paper_scene()}.turned());
}

}  // namespace
}  // namespace shaker::simulated
