// The cases of tests/bench/run control with two seeds each: limits that the loop must keep.
#include <gtest/gtest.h>

#include <cctype>

#include "tests/support/control/control_bench.hpp"

namespace shaker::control {
namespace {

using test::ControlCase;

class ClosedLoopTest : public ::testing::TestWithParam<ControlCase> {};

TEST_P(ClosedLoopTest, ReachesTheRequestedDrive) {
    const ControlCase& c = GetParam();
    for (std::uint64_t seed = 1; seed <= (SHAKER_SANITIZED ? 1 : 2); ++seed) {
        const test::ControlResult r = test::run_control(c, test::hybrid(), seed);
        if (c.lock_within > 0) {
            EXPECT_GE(r.lock60, 0) << "never locked";
            EXPECT_LE(r.lock60, c.lock_within);
            EXPECT_LT(std::abs(r.delta_mrad), 1);
        }
        EXPECT_LT(r.mean_db, c.mean_db);
        EXPECT_FALSE(r.gave_up);
    }
}

std::string words(const ::testing::TestParamInfo<ControlCase>& info) {
    std::string name;
    for (const char c : info.param.name) name += std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '_';
    return name;
}
INSTANTIATE_TEST_SUITE_P(Cases, ClosedLoopTest, ::testing::ValuesIn(test::control_cases()), words);

TEST(ClosedLoopLimitTest, HoldsReachableGammaWhenAmplifierClips) {
    for (const ControlCase& c : test::control_cases()) {
        if (c.name.find("clips") == std::string::npos) continue;
        const test::ControlResult r = test::run_control(c, test::hybrid(), 3);
        EXPECT_LT(r.reached, 0.9);
        EXPECT_GT(r.reached, 0.35);
    }
}

}  // namespace
}  // namespace shaker::control
