// After a power cut a recording has all synchronised data and no invalid data.
#include "tests/support/recording/power_cuts.hpp"

#include <gtest/gtest.h>

#include "tests/support/nightly.hpp"
#include "tests/support/program.hpp"

namespace shaker::recording {
namespace {

TEST(PowerCutsTest, SyncedDataSurviveAndBadDataAreDetected) {
    if (SHAKER_SANITIZED) GTEST_SKIP() << "sanitisers do not allow a preloaded library";
    const auto folder = test::fresh_folder();
    const test::PowerCuts run{folder / "reference"};
    EXPECT_GE(run.syncs(), 10U);
    EXPECT_GE(run.calls(), 1000U);
    for (const auto surviving : {test::Surviving::all, test::Surviving::half, test::Surviving::synced}) {
        int of_synced = 0;
        const auto seeds = static_cast<std::uint64_t>(test::plays(5, 170));
        for (std::uint64_t k = 0; k < seeds; ++k) {
            const std::uint64_t seed = test::seed_of_day(1) + k;
            SCOPED_TRACE(testing::Message() << name(surviving) << ", seed " << seed);
            const auto image = folder / "image";
            std::filesystem::create_directories(image);
            const test::PowerCut cut = run.cut(surviving, seed, image);
            std::filesystem::remove_all(image);
            EXPECT_EQ(cut.synced_lost, 0U) << cut.words;
            EXPECT_EQ(cut.bad, 0U) << cut.words;
            if (!cut.anything_synced) continue;
            ++of_synced;
            EXPECT_TRUE(cut.recovered) << cut.words;
        }
        EXPECT_GE(of_synced, 2);
        std::printf("%s: %d of %d cuts after the first sync\n", name(surviving), of_synced,
                    static_cast<int>(seeds));
    }
}

}  // namespace
}  // namespace shaker::recording
