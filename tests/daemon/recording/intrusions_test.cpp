// Other programs cannot take pictures or names from a recording in progress.
#include "tests/support/recording/intrusions.hpp"

#include <gtest/gtest.h>

#include "tests/support/program.hpp"

namespace shaker::recording {
namespace {

TEST(IntrusionsTest, RecordingLosesNothingAndReplacesNothing) {
    if (SHAKER_SANITIZED) GTEST_SKIP() << "a sanitised program is slower than real time";
    const char* nightly = std::getenv("SHAKER_NIGHTLY");
    const bool all = nightly != nullptr && std::string{nightly} == "1";
    for (const test::Intrusion& one :
         test::intrusions(all ? 200 : test::intruders, 7, all ? 2 : 1, test::fresh_folder())) {
        SCOPED_TRACE(testing::Message() << name(one.intruder) << " at " << one.at_s << " s");
        EXPECT_TRUE(one.wrong.empty()) << one.wrong.front();
        EXPECT_GT(one.produced, 500U);
        EXPECT_EQ(one.lost, 0U);
        EXPECT_FALSE(one.replaced);
    }
}

}  // namespace
}  // namespace shaker::recording
