// New regions of targets by an order, at rest.
#include <gtest/gtest.h>

#include <algorithm>

#include "daemon/commands/replay.hpp"
#include "drivers/recorded/recording_file.hpp"
#include "tests/support/run/bench_on_call.hpp"

namespace shaker::service {
namespace {

using run::RunState;
using test::in;
using test::until;

using Region = std::array<int, 4>;

class MoveTargetsTest : public test::OnCallBench {
protected:
    [[nodiscard]] std::function<void(BenchPort&)> move(const char* camera, const char* target,
                                                       std::array<double, 4> roi_px) {
        return give(MoveTargets{{{camera, target, roi_px}}});
    }
    /// The regions when the bench is idle for the first time, before the next move.
    [[nodiscard]] test::Move look() {
        return until([this](const BenchState& s) {
            if (s.state == RunState::idle && s.pictures_now.at(0).frame) first = s.facts->views;
            return !first.empty();
        });
    }
    [[nodiscard]] static Region region(const std::vector<View>& views, std::size_t camera,
                                       const char* target) {
        const auto& all = views.at(camera).targets;
        return std::ranges::find(all, target, &Target::name)->roi_px;
    }

    std::vector<View> first;
};

/// A region a few pixels larger on each side.
std::array<double, 4> wider(const Region& r) { return {r[0] - 3.0, r[1] - 2.0, r[2] + 6.0, r[3] + 4.0}; }

// The recording has the new region, and its pictures replay from there.
TEST_F(MoveTargetsTest, RegionIsInForceAndRecorded) {
    options.pictures = recorded::KeptPictures::full;
    Region asked{};
    const auto r =
        play(test::rendered, {look(),
                              {in(RunState::idle),
                               [&](BenchPort& port) {
                                   const auto to = wider(region(first, 0, "walker"));
                                   std::ranges::transform(to, asked.begin(),
                                                          [](double x) { return static_cast<int>(x); });
                                   move("top", "walker", to)(port);
                               }},
                              {in(RunState::idle), give(Record{true, "moved", recorded::KeptPictures::full})},
                              start(),
                              {test::measured(1), give(End{})},
                              until(in(RunState::idle))});
    EXPECT_EQ(answers, test::Answers(4, "")) << test::log_of(r);
    EXPECT_EQ(region(r.last.facts->views, 0, "walker"), asked);
    EXPECT_EQ(region(r.last.facts->views, 0, "base"), region(first, 0, "base"));
    EXPECT_EQ(r.last.points.size(), 1U) << test::log_of(r);
    const recorded::RecordingReader read{folder / "moved.nxs"};
    EXPECT_EQ(region(read.header().views, 0, "walker"), asked) << "the walker has not moved before the run";
    EXPECT_TRUE(commands::replay({.file = read.file(), .from = commands::ReplayOptions::From::raw}));
}

TEST_F(MoveTargetsTest, PositionsAreRecordedWithTheNewRegion) {
    Region asked{};
    const auto r =
        play(test::rendered,
             {look(),
              {in(RunState::idle),
               [&](BenchPort& port) {
                   const Region old = region(first, 1, "walker");
                   asked = {old[0] - 4, old[1], old[2] + 8, old[3]};
                   move("side", "walker", {old[0] - 4.0, double(old[1]), old[2] + 8.0, double(old[3])})(port);
               }},
              {in(RunState::idle), give(Record{true, "moved", recorded::KeptPictures::off})},
              start(),
              {test::measured(1), give(End{})},
              until(in(RunState::idle))});
    EXPECT_EQ(answers, test::Answers(4, "")) << test::log_of(r);
    const recorded::RecordingReader read{folder / "moved.nxs"};
    EXPECT_EQ(region(read.header().views, 1, "walker"), asked);
}

// Each refusal says camera, target, value and what is allowed; nothing changes.
TEST_F(MoveTargetsTest, WrongRegionsAreRefused) {
    const auto r =
        play(test::rendered,
             {look(),
              {in(RunState::idle), move("front", "walker", {0, 0, 9, 9})},
              {in(RunState::idle), move("top", "wheel", {0, 0, 9, 9})},
              {in(RunState::idle), move("top", "walker", {-1, 0, 9, 9})},
              {in(RunState::idle), move("top", "walker", {5, 5, 20.5, 9})},
              {in(RunState::idle), move("top", "walker", {5000, 0, 90, 90})},
              {in(RunState::idle), move("top", "walker", {0, 0, 24, 24})},
              {in(RunState::idle), give(MoveTargets{})},
              {in(RunState::idle),
               give(MoveTargets{{{"top", "base", {0, 0, 9, 9}}, {"top", "base", {0, 0, 9, 9}}}})}});
    ASSERT_EQ(answers.size(), 8U);
    const std::array<std::vector<const char*>, 8> words{{
        {"camera \"front\"", "expected \"top\", \"side\""},
        {"camera \"top\", target \"wheel\"", "expected \"walker\", \"base\""},
        {"camera \"top\", target \"walker\"", "[-1, 0, 9, 9]", "x and y at least 0", "got -1"},
        {"camera \"top\", target \"walker\"", "whole pixels", "got 20.5"},
        {"camera top, target walker, roi_px [5000, 0, 90, 90]", "at least half must be inside the image of"},
        {"camera top, target walker, roi_px [0, 0, 24, 24]"},
        {"no target was given"},
        {"camera \"top\", target \"base\"", "a second region"},
    }};
    for (std::size_t i = 0; i < words.size(); ++i)
        for (const char* word : words[i])
            EXPECT_NE(answers[i].find(word), std::string::npos) << answers[i] << "\nlacks: " << word;
    for (std::size_t camera : {0U, 1U})
        for (const char* target : {"walker", "base"})
            EXPECT_EQ(region(r.last.facts->views, camera, target), region(first, camera, target));
}

TEST_F(MoveTargetsTest, DrivenBenchRefuses) {
    play(test::rendered, {look(),
                          start(),
                          {test::in(RunState::run), move("top", "walker", {0, 0, 9, 9})},
                          {test::in(RunState::run), give(End{})},
                          until(in(RunState::idle))});
    ASSERT_EQ(answers.size(), 3U);
    EXPECT_NE(answers[1].find("while the bench is running; wait until it is idle, or stop the drive"),
              std::string::npos)
        << answers[1];
}

TEST_F(MoveTargetsTest, PositionsHaveNoRegions) {
    play(test::slow, {{in(RunState::idle), move("top", "walker", {0, 0, 9, 9})}});
    ASSERT_EQ(answers.size(), 1U);
    EXPECT_NE(answers[0].find("camera \"top\": gives positions instead of pictures"), std::string::npos)
        << answers[0];
}

// After a run the walker is elsewhere: the proposed region has gone with it, and it is accepted.
TEST_F(MoveTargetsTest, ProposedRegionFollowsTheTarget) {
    Region proposed{};
    const auto r = play(test::rendered, {look(),
                                         start(),
                                         {test::measured(1), give(End{})},
                                         until([&](const BenchState& s) {
                                             if (s.state != RunState::idle || s.points.empty()) return false;
                                             proposed = s.pictures_now.at(0).regions_now.at(0).value();
                                             return true;
                                         }),
                                         {in(RunState::idle), [&](BenchPort& port) {
                                              std::array<double, 4> to{};
                                              std::ranges::copy(proposed, to.begin());
                                              move("top", "walker", to)(port);
                                          }}});
    EXPECT_EQ(answers, test::Answers(3, "")) << test::log_of(r);
    const Region before = region(first, 0, "walker");
    EXPECT_GT(std::abs(proposed[0] - before[0]), 2) << "the walker has walked";
    EXPECT_EQ(proposed[2], before[2]);
    EXPECT_EQ(region(r.last.facts->views, 0, "walker"), proposed);
}

}  // namespace
}  // namespace shaker::service
