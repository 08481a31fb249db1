// A killed run leaves a recoverable recording.
#include "tests/support/recording/kills.hpp"

#include <gtest/gtest.h>

#include "tests/support/nightly.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/program.hpp"

namespace shaker::recording {
namespace {

TEST(KillsTest, KilledRunIsRecoveredAndReplayed) {
    if (SHAKER_SANITIZED) GTEST_SKIP() << "a sanitised program is slower than real time";
    const test::KilledRun run{.scene = test::source_dir() + "/tests/support/slow_cameras.toml",
                              .longest_s = 3};
    const int count = test::plays(3, 200);
    std::vector<double> lost_s;
    for (const test::Kill& kill :
         test::kill_runs(run, count, test::seed_of_day(5), 1, test::fresh_folder())) {
        SCOPED_TRACE(testing::Message() << "killed at " << kill.at_s << " s");
        EXPECT_TRUE(kill.recovered);
        EXPECT_TRUE(kill.whole);
        EXPECT_TRUE(kill.replayed);
        EXPECT_TRUE(kill.wrong.empty()) << kill.wrong.front();
        EXPECT_GE(kill.series_lost_s, 0);
        EXPECT_LE(kill.series_lost_s, 1.0);  // 0.6 on an idle machine
        lost_s.push_back(kill.series_lost_s);
    }
    std::ranges::sort(lost_s);
    std::printf("%d kills; the series lost %.2f s at the median, %.2f s at most\n", count,
                lost_s.at(lost_s.size() / 2), lost_s.back());
}

}  // namespace
}  // namespace shaker::recording
