#include "daemon/safety/limits.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "drivers/errors.hpp"

namespace shaker::safety {
namespace {

// A B&K 4809 under a base of 0.5 kg, an ADXL355 at 8 g, 1 V of DAC.
const DataSheet sheet{.max_force_n = 45,
                      .moving_mass_kg = 0.057,
                      .load_kg = 0.5,
                      .stroke_m = 8e-3,
                      .max_velocity_mps = 1.65,
                      .max_acceleration_mps2 = 736,
                      .sensor_range_mps2 = 78.5,
                      .full_scale_V = 1,
                      .max_coil_A = 4.7,
                      .coil_A_per_V = 5};

Limits parsed(const std::string& toml) {
    SettingsTable root = SettingsTable::from_text(toml, "bench.toml");
    Limits l = read_limits(root.table("limits"), sheet);
    root.finish();
    return l;
}

std::string refusal(const std::string& toml) {
    try {
        parsed(toml);
    } catch (const InputError& e) {
        return e.what();
    }
    return "accepted";
}

TEST(LimitsTest, DefaultsAreEightyPercentOfTheDataSheet) {
    const Limits l = limits_of(sheet);
    EXPECT_NEAR(l.acceleration.abort, 0.8 * 78.5, 1e-12)
        << "the sensor is the least, 45 N / 0.557 kg is 80.8";
    EXPECT_NEAR(l.acceleration_rms.abort, 0.8 * 78.5 / std::sqrt(2), 1e-12) << "of a sine";
    EXPECT_NEAR(l.coil_A.abort, 3.76, 1e-12);
    EXPECT_EQ(l.coil_A_per_V, 5);
    EXPECT_NEAR(l.velocity.abort, 1.32, 1e-12);
    EXPECT_NEAR(l.displacement.abort, 3.2e-3, 1e-15);
    EXPECT_NEAR(l.displacement.warn, 2.56e-3, 1e-15);
    EXPECT_NEAR(l.force_n, 36, 1e-12);
    EXPECT_EQ(l.drive.abort, 1) << "the DAC is no weaker for it";
    EXPECT_EQ(l.detectors, all_detectors);
    EXPECT_NEAR(limits_of({.max_force_n = 10, .moving_mass_kg = 0.5, .load_kg = 0.5}).acceleration.abort, 8,
                1e-12);
    EXPECT_TRUE(std::isinf(limits_of({}).displacement.abort)) << "what is not known is no limit";
}

TEST(LimitsTest, TableSetsItsKeysAndMarginTheRest) {
    const Limits l = parsed(
        "[limits]\nmargin = 0.5\ndisplacement_abort_mm = 2\nsoft_stop_s = 0.1\n"
        "tracking_lost_frames = 7\nvelocity_warn_mps = 0.1\n");
    EXPECT_NEAR(l.displacement.abort, 2e-3, 1e-15);
    EXPECT_NEAR(l.displacement.warn, 1.6e-3, 1e-15);
    EXPECT_NEAR(l.velocity.abort, 0.825, 1e-12);
    EXPECT_EQ(l.velocity.warn, 0.1);
    EXPECT_EQ(l.stop_s(StopKind::soft), 0.1);
    EXPECT_EQ(l.stop_s(StopKind::hard), 0.005);
    EXPECT_EQ(l.tracking_lost_frames, 7);
    EXPECT_EQ(parsed(""), limits_of(sheet));
}

TEST(LimitsTest, RmsFollowsThePeakThatIsGiven) {
    EXPECT_NEAR(parsed("[limits]\nacceleration_abort_mps2 = 20\n").acceleration_rms.abort, 20 / std::sqrt(2),
                1e-12);
    EXPECT_EQ(parsed("[limits]\nacceleration_abort_mps2 = 20\nacceleration_rms_abort_mps2 = 5\n")
                  .acceleration_rms.abort,
              5);
}

TEST(LimitsTest, TextReadsBackAsTheSameLimits) {
    for (const char* toml :
         {"", "[limits]\nmargin = 0.37\nedge_mm = 3.3\nmissing_s = 0.0123\n",
          "[limits]\ntransverse_abort = 0.123456789012345\nwatchdog_s = 2\n",
          "[limits]\nacceleration_abort_mps2 = 20\ncoil_abort_A = 3\ncoil_time_s = 30\n"}) {
        const Limits l = parsed(toml);
        const Limits again = parsed(limits_text(l));
        EXPECT_EQ(limits_text(again), limits_text(l));
        EXPECT_NEAR(again.displacement.abort, l.displacement.abort, 1e-15 * l.displacement.abort);
    }
    SettingsTable root = SettingsTable::from_text(limits_text(limits_of({})), "open.toml");
    EXPECT_EQ(read_limits(root.table("limits"), {}), limits_of({})) << "also where levels are infinite";
}

TEST(LimitsTest, NamesErrorsWithFileLineKeyAndRange) {
    const auto expect = [](const std::string& toml, const std::vector<std::string>& parts) {
        const std::string said = refusal(toml);
        for (const std::string& part : parts) EXPECT_NE(said.find(part), std::string::npos) << said;
    };
    expect("[limits]\nsoft_stop_s = 0.5\n", {"bench.toml:2", "limits.soft_stop_s", "0.5", "0.02 to 0.2"});
    expect("[limits]\ndisplacement_abort_mm = 2\ndisplacement_warn_mm = 3\n",
           {"bench.toml:3", "displacement_warn_mm", "3", "displacement_abort_mm", "2"});
    expect("[limits]\ndisplacement_warn_mm = 3.3\n", {"bench.toml:2", "3.2"});
    expect("[limits]\nacceleration_abort = 3\n", {"acceleration_abort", "acceleration_abort_mps2"});
    expect("[limits]\nmargin = 1.5\n", {"margin", "0.1 to 1"});
    expect("[limits]\ndrive_abort_V = -1\n", {"drive_abort_V", "-1"});
    expect("[limits]\ndetectors = 0\n", {"detectors"});
}

}  // namespace
}  // namespace shaker::safety
