// The folder of a campaign is made once, belongs to one process, and is continued with the same plan.
#include "daemon/campaign/campaign_folder.hpp"

#include <gtest/gtest.h>
#include <spdlog/fmt/fmt.h>
#include <unistd.h>

#include "drivers/recorded/h5/h5.hpp"
#include "tests/support/recording/recording_folder.hpp"

namespace shaker::campaign {
namespace {

using test::expect_in;
using test::refusal;

constexpr const char* plan = "[[series]]\nname = \"a\"\ngamma = [\"1g\"]\n";

class CampaignFolderTest : public testing::Test {
protected:
    [[nodiscard]] std::string text(const char* name) const {
        std::ifstream in{path_ / name, std::ios::binary};
        return {std::istreambuf_iterator<char>{in}, {}};
    }
    [[nodiscard]] std::string refused_to_continue(
        const std::optional<std::string>& with = std::nullopt) const {
        return refusal([&] { CampaignFolder::continued(path_, with); });
    }
    test::SessionFolder folder_;
    std::filesystem::path path_ = folder_ / "campaign";
};

TEST_F(CampaignFolderTest, NewFolderHasPlanAndJournal) {
    {
        CampaignFolder made = CampaignFolder::begin(path_, plan);
        made.add(PointBegun{1});
    }
    EXPECT_EQ(text("plan.toml"), plan);
    const StoredCampaign stored = read_campaign(path_);
    EXPECT_EQ(stored.plan, plan);
    EXPECT_EQ(stored.entries.size(), 2U);
    EXPECT_NE(stored.entries[0].time, "");
    EXPECT_FALSE(stored.progress.done(1));
}

TEST_F(CampaignFolderTest, ContinuesWithWhatWasMeasured) {
    {
        CampaignFolder made = CampaignFolder::begin(path_, plan);
        made.add(PointBegun{1});
        made.add(PassEnded{.point = 1, .recording = "r1", .measurement = 1, .reason = {}});
        made.add(PointEnded{1});
    }
    std::ofstream{path_ / "journal.jsonl", std::ios::app} << R"({"what":"point be)";
    {
        CampaignFolder again = CampaignFolder::continued(path_, plan);
        expect_in(again.stored().remark, {"line 5", "dropped"});
        EXPECT_TRUE(again.stored().progress.done(1));
        again.add(PointBegun{2});
    }
    const StoredCampaign stored = read_campaign(path_);
    EXPECT_EQ(stored.entries.size(), 6U);
    EXPECT_EQ(std::get<CampaignChange>(stored.entries[4].what).what, CampaignChange::What::continued);
}

TEST_F(CampaignFolderTest, FolderThatIsNotEmptyIsRefused) {
    std::filesystem::create_directory(path_);
    std::ofstream{path_ / "mine.txt"} << "mine";
    expect_in(refusal([&] { CampaignFolder::begin(path_, plan); }), {path_.string(), "not empty"});
    EXPECT_FALSE(std::filesystem::exists(path_ / "plan.toml"));
    expect_in(refused_to_continue(), {path_.string(), "not the folder of a campaign"});
    EXPECT_FALSE(std::filesystem::exists(path_ / "journal.jsonl")) << "a refusal leaves nothing";
    std::filesystem::remove(path_ / "mine.txt");
    CampaignFolder::begin(path_, plan);
    expect_in(refusal([&] { CampaignFolder::begin(path_, plan); }), {path_.string(), "--continue"});
}

TEST_F(CampaignFolderTest, SecondCampaignInFolderIsRefused) {
    const CampaignFolder first = CampaignFolder::begin(path_, plan);
    expect_in(refused_to_continue(),
              {path_.string(), "process " + std::to_string(::getpid()), "another folder"});
    EXPECT_EQ(read_campaign(path_).entries.size(), 1U) << "reading needs no lock";
}

TEST_F(CampaignFolderTest, OtherPlanIsRefused) {
    { CampaignFolder::begin(path_, plan); }
    const std::optional<std::string> other{fmt::format("{}# other\n", plan)};
    expect_in(refused_to_continue(other), {path_.string(), "another plan"});
    std::ofstream{path_ / "plan.toml", std::ios::app} << "# changed by hand\n";
    expect_in(refused_to_continue(), {"plan.toml", "was changed", "restore"});
}

// A folder that an earlier version spoiled is continued, with a remark on what it says twice.
TEST_F(CampaignFolderTest, LateEntryIsARemark) {
    CampaignFolder::begin(path_, plan).add(PassEnded{.point = 4});
    const CampaignFolder again = CampaignFolder::continued(path_);
    ASSERT_EQ(again.stored().progress.remarks.size(), 1U);
    expect_in(again.stored().progress.remarks.front(), {"entry 2", "point 4 is not in progress"});
}

TEST_F(CampaignFolderTest, WhatTheReaderRefusesIsNotWritten) {
    CampaignFolder made = CampaignFolder::begin(path_, plan);
    made.add(CampaignChange{CampaignChange::What::begun, {}, "another"});
    made.add(PointBegun{.point = 1});
    EXPECT_EQ(read_campaign(path_).entries.size(), 2U);
}

TEST_F(CampaignFolderTest, ContinuesAfterDeathWhileItWasMade) {
    std::filesystem::create_directory(path_);
    std::ofstream{path_ / "plan.toml"} << plan;
    std::ofstream{path_ / "journal.jsonl"};
    { CampaignFolder::continued(path_); }
    EXPECT_NE(read_campaign(path_).progress.plan, "");
}

}  // namespace
}  // namespace shaker::campaign
