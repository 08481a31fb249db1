// Complete replays of damaged recordings in the confined child.
#include "tests/support/recording/mutants.hpp"

#include <gtest/gtest.h>

#include <map>

#include "daemon/commands/replay.hpp"
#include "tests/support/nightly.hpp"
#include "tests/support/program.hpp"

namespace shaker::test {
namespace {

class MutantsTest : public testing::Test {
protected:
    std::filesystem::path folder_ = fresh_folder();
    MutantTrials trials_{folder_, false};
};

TEST_F(MutantsTest, ParentSurvivesAnyFateOfReader) {
    const auto mutants = static_cast<std::uint64_t>(plays(SHAKER_SANITIZED != 0 ? 40 : 150, 2000));
    const std::uint64_t first = 1'000'000 * (seed_of_day(0));
    std::map<Fate, std::uint64_t> fates;
    std::uint64_t sealed_refused = 0;
    for (std::uint64_t seed = first + 1; seed <= first + mutants; ++seed) {
        const Trial t = trials_.attempt(seed);
        EXPECT_EQ(t.parent_harm, "") << "seed " << seed << ", " << t.mutant.what;
        EXPECT_NE(t.fate, Fate::unclear) << "seed " << seed << ", " << t.mutant.what << t.said;
        EXPECT_NE(t.fate, Fate::timed_out) << "seed " << seed << ", " << t.mutant.what;
        ++fates[t.fate];
        if (t.fate == Fate::refused && t.mutant.sealed) ++sealed_refused;
    }
    // The rest are errors of HDF5 1.10 with wrong structure and valid checksums.
    EXPECT_LE(fates[Fate::died], 2 + mutants / 500);
    EXPECT_GT(fates[Fate::refused], mutants / 3);
    EXPECT_GT(sealed_refused, mutants / 15) << "damage with valid checksums must be detected too";
    EXPECT_GT(fates[Fate::identical], 0) << "some bytes have no meaning";
}

TEST_F(MutantsTest, IntactRecordingReplaysInChildAsInParent) {
    testing::internal::CaptureStdout();
    const bool identical = commands::replay({.file = folder_ / "run.nxs", .json = true});
    const std::string here = testing::internal::GetCapturedStdout();
    const Outcome child = shakerd("replay --json run.nxs", folder_);
    EXPECT_TRUE(identical);
    EXPECT_EQ(child.status, 0) << child.err;
    // In this program the log also goes to standard output.
    const std::size_t begin = here.find("{\n"), end = here.rfind("\n}\n");
    ASSERT_NE(begin, std::string::npos) << here;
    ASSERT_NE(end, std::string::npos) << here;
    EXPECT_TRUE(child.out == here.substr(begin, end + 3 - begin)) << child.out;
}

TEST_F(MutantsTest, TruncatedRecordingIsRefused) {
    std::filesystem::resize_file(folder_ / "run.nxs", 5000);
    const Outcome child = shakerd("replay run.nxs", folder_);
    EXPECT_EQ(child.status, 2) << child.err;
    EXPECT_NE(child.err.find("shakerd: "), std::string::npos) << child.err;
}

}  // namespace
}  // namespace shaker::test
