// Runs with an analog accelerometer on the inputs of a sound card: real libasound in both directions.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/support/in_real_time.hpp"
#include "tests/support/run/bench_run.hpp"

namespace shaker::test {
namespace {

// One card: the sensor has the clock of the drive. The corner of 0.05 Hz turns phi by 3.75 mrad at 20 Hz.
const std::string one_card =
    "[accelerometer]\naxes = 1\ngravity = 0\nhigh_pass_hz = 0.05\nyaw_deg = 0\nrate_hz = 48000\nclock_ppm = "
    "0\n"
    "bits = 24\n";

TEST(LineInputTest, ResultsAreTrueOnOneCard) {
    BenchRun run{37.5, one_card, true};
    run.start("--gamma 1g --phi 100deg --periods 40 -o run.nxs");
    if (!in_real_time) return expect_order(run.finish());
    const nlohmann::json r = run.results();
    ASSERT_FALSE(r.empty());
    EXPECT_NEAR(r.at("gamma_mps2"), 9.8, 0.01);
    EXPECT_NEAR(r.at("dac_ppm"), 37.5, 1);
    EXPECT_EQ(device(r, "input shaker_line").at("lost"), 0);
    EXPECT_TRUE(r.at("bench_check").at("tilt_rad").is_null());
    EXPECT_TRUE(r.at("harmonics").at(0).at("across").is_null());
    EXPECT_TRUE(noted(r, "motion across the shaker's axis is not known"));
    EXPECT_TRUE(noted(r, "tilt by gravity is not known"));
    const double v_true = run.bench.drift(1, r.at("from_s"), r.at("to_s"));
    EXPECT_NEAR(r.at("v_D_mps"), v_true, 8 * r.at("v_D_se_mps").get<double>() + 1e-4 * v_true);
    const Outcome again = shakerd("replay run.nxs", run.folder);
    EXPECT_EQ(again.status, 0) << again.out << again.err;
}

TEST(LineInputTest, AnInputThatIsUnpluggedStopsTheDrive) {
    BenchRun run{0, one_card, true};
    run.start("--gamma 0.5g --periods 2000");
    if (!in_real_time) return expect_order(run.finish());
    ASSERT_TRUE(run.played(6)) << end_of(run.finish().err);
    run.bench.line_input().unplug();
    const Outcome o = run.finish();
    EXPECT_EQ(o.status, 5) << end_of(o.err);
    EXPECT_NE((o.out + o.err).find("sensor_missing"), std::string::npos) << o.out << end_of(o.err);
}

}  // namespace
}  // namespace shaker::test
