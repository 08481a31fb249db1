// Mains that hide a driven harmonic degrade the measurements at that drive, and no later ones.
#include <gtest/gtest.h>

#include "tests/support/run/bench_on_call.hpp"

namespace shaker::service {
namespace {

struct MainsDoubtTest : test::OnCallBench {};

auto measured_at(double frequency) {
    return [frequency](const BenchState& s) {
        return s.result != nullptr && s.result_origin.asked.frequency == frequency;
    };
}

TEST_F(MainsDoubtTest, EndsWithTheDriveThatItIsOf) {
    options.drive.frequency = 25;
    options.drive.gamma = 3;  // a slow walker
    Drive other = options.drive;
    other.frequency = 20;
    std::string scene = test::slow;
    scene += "[accelerometer]\nmains_mps2 = 0.02\nmains_hz = 50.03\n";
    bool degraded_before = false, degraded_after = true;
    const auto r = play(scene,
                        {start(),
                         {[&](const BenchState& s) {
                              if (measured_at(25)(s)) degraded_before = s.result->degraded;
                              return measured_at(25)(s);
                          },
                          give(SetDrive{other})},
                         {[&](const BenchState& s) {
                              if (measured_at(20)(s)) degraded_after = s.result->degraded;
                              return measured_at(20)(s);
                          },
                          give(End{})},
                         test::until(test::in(run::RunState::idle))},
                        120);
    EXPECT_EQ(answers, test::Answers(3, ""));
    EXPECT_TRUE(degraded_before);
    EXPECT_FALSE(degraded_after);
    EXPECT_NE(test::log_of(r).find(
                  "harmonic 2 of 25 Hz lies on a line of the mains, and the set-point asks for it"),
              std::string::npos)
        << test::log_of(r);
}

}  // namespace
}  // namespace shaker::service
