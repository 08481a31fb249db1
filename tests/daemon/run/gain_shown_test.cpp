// Which benches drive at half of their limits: those where nothing shows the gain of the accelerometer.
#include <gtest/gtest.h>

#include <fstream>

#include "daemon/bench/bench.hpp"
#include "daemon/run/run_setup.hpp"
#include "daemon/run/runner.hpp"
#include "tests/support/program.hpp"

namespace shaker::run {
namespace {

/// The simulated bench with these changes.
bench::Bench bench_with(const std::string& changes) {
    const auto scene = test::fresh_folder() / "scene.toml";
    std::ofstream{scene} << changes;
    return bench::open_bench("sim:", scene, simulated::World::Pace::lockstep);
}

TEST(GainShownTest, GravityNeedsItsThreeAxes) {
    const auto without_cameras = [](const std::string& changes) {
        bench::Bench bench = bench_with(changes);
        EXPECT_TRUE(gain_shown(bench.rig)) << "the cameras see the base";
        bench.rig.cameras.clear();
        return gain_shown(bench.rig);
    };
    EXPECT_TRUE(without_cameras(""));
    EXPECT_FALSE(without_cameras("[accelerometer]\naxes = 1\n"));
    EXPECT_FALSE(without_cameras("[accelerometer]\naxes = 2\n"));
    EXPECT_FALSE(without_cameras("[accelerometer]\ngravity = 0\n"));
}

TEST(GainShownTest, HalfLimitsStayHalfAfterAReload) {
    const auto scene = test::fresh_folder() / "scene.toml";
    std::ofstream{scene} << "[limits]\nacceleration_abort_mps2 = 30\n";
    bench::Bench bench = bench::open_bench("sim:", scene, simulated::World::Pace::lockstep);
    const safety::Limits full = limits_now(bench, "sim:", scene).limits;
    bench.halved = true;
    const safety::Limits half = limits_now(bench, "sim:", scene).limits;
    EXPECT_EQ(full.acceleration.abort, 30);
    EXPECT_EQ(half.acceleration.abort, 15);
    EXPECT_EQ(half.drive.abort, full.drive.abort / 2);
    EXPECT_EQ(half.missing_s, full.missing_s);
}

}  // namespace
}  // namespace shaker::run
