// A frequency that the accelerometer cannot follow is refused; the bench would wait for its first window for
// ever.
#include <gtest/gtest.h>

#include "daemon/run/run_setup.hpp"
#include "daemon/run/runner.hpp"
#include "drivers/errors.hpp"

namespace shaker::run {
namespace {

std::string refusal(double frequency) {
    RunnerSettings settings;
    settings.run.rig = "sim:";
    settings.run.standard = simulated::paper_scene(simulated::Detail::positions);
    settings.run.drive.frequency = frequency;
    try {
        const Runner runner{settings};
        return "accepted";
    } catch (const InputError& e) {
        return e.what();
    }
}

TEST(FrequencyRangeTest, AccelerometerNeedsSamplesInEachPeriod) {
    EXPECT_EQ(refusal(166), "accepted");
    const std::string why = refusal(167);
    EXPECT_NE(why.find("frequency 167 Hz"), std::string::npos) << why;
    EXPECT_NE(why.find("at most 166.6 Hz is allowed"), std::string::npos) << why;
}

}  // namespace
}  // namespace shaker::run
