// A campaign that was interrupted and goes on counts all its seeds.
#include "tests/orders/campaign.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/program.hpp"

namespace shaker::orders {
namespace {

TEST(CampaignTest, ResumedSearchCountsEarlierSeeds) {
    const auto folder = test::fresh_folder();
    const auto play_seeds = [&](std::uint64_t seeds, const char* done) {
        return play({.first = 4, .seeds = seeds, .done = folder / done, .folder = folder / "work"});
    };
    const Totals whole = play_seeds(4, "whole.json");
    const Totals part = play_seeds(2, "parts.json");
    std::ofstream{folder / "parts.json", std::ios::app} << "{\"seed\": 6, \"torn by a power";
    std::ofstream{folder / "parts.json", std::ios::app} << '\n';
    const Totals again = play_seeds(4, "parts.json");
    EXPECT_TRUE(whole.broken.empty());
    EXPECT_EQ(again.seeds, 4U);
    EXPECT_LT(again.played_s, again.virtual_s);
    EXPECT_NEAR(again.played_s, whole.virtual_s - part.virtual_s, 1e-6);
    const auto all = whole.coverage.pairs(), got = again.coverage.pairs(), few = part.coverage.pairs();
    for (std::size_t i = 0; i < all.size(); ++i) {
        EXPECT_EQ(got[i].met, all[i].met) << all[i].what;
        EXPECT_EQ(got[i].rare, all[i].rare) << all[i].what;
        EXPECT_LE(few[i].met, all[i].met) << all[i].what;
    }
    EXPECT_NE(part.coverage.numbers(), whole.coverage.numbers()) << "the later seeds count";
    EXPECT_EQ(again.coverage.numbers(), whole.coverage.numbers());
    EXPECT_EQ(play_seeds(4, "parts.json").coverage.numbers(), whole.coverage.numbers())
        << "with nothing left to play";
}

TEST(CampaignTest, OutcomeOfAnotherVersionIsRefused) {
    Coverage coverage;
    auto numbers = coverage.numbers();
    coverage.add(numbers);
    ++numbers.at(1);
    EXPECT_THROW(coverage.add(numbers), std::runtime_error);
}

}  // namespace
}  // namespace shaker::orders
