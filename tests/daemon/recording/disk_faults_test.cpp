// A disk that is full, fails or stalls under a run.
#include "tests/support/recording/disk_faults.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>

#include "tests/support/program.hpp"

namespace shaker::recording {
namespace {

class DiskFaultsTest : public testing::TestWithParam<const char*> {};

TEST_P(DiskFaultsTest, RunEndsCorrectlyAndRecordedDataAreIntact) {
    if (SHAKER_SANITIZED) GTEST_SKIP() << "sanitisers do not allow a preloaded library";
    const auto& all = test::disk_faults();
    const auto fault = std::ranges::find(all, std::string{GetParam()}, &test::DiskFault::name);
    ASSERT_NE(fault, all.end());
    const test::AfterFault after = test::run_with(*fault, test::fresh_folder());
    EXPECT_TRUE(after.wrong.empty()) << after.wrong.front() << "\n" << after.words;
}

TEST(EveryDiskFaultTest, RunEndsCorrectlyAndRecordedDataAreIntact) {
    if (SHAKER_SANITIZED) GTEST_SKIP() << "sanitisers do not allow a preloaded library";
    const auto folder = test::fresh_folder();
    for (const test::DiskFault& fault : test::disk_faults()) {
        SCOPED_TRACE(fault.name);
        std::filesystem::create_directories(folder);
        const test::AfterFault after = test::run_with(fault, folder);
        EXPECT_TRUE(after.wrong.empty()) << after.wrong.front() << "\n" << after.words;
        std::filesystem::remove_all(folder);
    }
}

// ulimit -f, or the limit of a batch system.
TEST(FileSizeLimitTest, IsAFailureOfTheDiskThatNamesTheFile) {
    const auto folder = test::fresh_folder();
    rlimit before{};
    ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
    const rlimit small{20'480'000, before.rlim_max};
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
    const test::Outcome o = test::shakerd("run --phi 2.17 --periods 200 -o limited.nxs", folder);
    setrlimit(RLIMIT_FSIZE, &before);
    EXPECT_EQ(o.status, 3) << o.out << o.err;
    EXPECT_NE(o.err.find("limited.nxs"), std::string::npos) << o.err;
    EXPECT_NE(o.err.find("File too large"), std::string::npos) << o.err;
}

INSTANTIATE_TEST_SUITE_P(OfAFewSeconds, DiskFaultsTest,
                         testing::Values("full before the start", "ENOSPC of all from 3 s on",
                                         "EIO of the series", "EIO of the pictures"),
                         [](const auto& of) { return "Fault" + std::to_string(of.index); });

}  // namespace
}  // namespace shaker::recording
