// Other programs cannot take pictures or names from a recording in progress.
#include "tests/support/recording/intrusions.hpp"

#include <gtest/gtest.h>

#include "tests/support/nightly.hpp"
#include "tests/support/program.hpp"

namespace shaker::recording {
namespace {

TEST(IntrusionsTest, RecordingLosesNothingAndReplacesNothing) {
    if (SHAKER_SANITIZED) GTEST_SKIP() << "a sanitised program is slower than real time";
    const int count = test::plays(test::intruders, 200);
    for (const test::Intrusion& one : test::intrusions(
             count, test::seed_of_day(7), count > test::intruders ? 2 : 1, test::fresh_folder())) {
        SCOPED_TRACE(testing::Message() << name(one.intruder) << " at " << one.at_s << " s");
        EXPECT_TRUE(one.wrong.empty()) << one.wrong.front();
        EXPECT_GT(one.produced, 500U);
        EXPECT_EQ(one.lost, 0U);
        EXPECT_FALSE(one.replaced);
    }
}

}  // namespace
}  // namespace shaker::recording
