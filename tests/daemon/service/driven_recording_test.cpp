// Recordings that start and end while the drive runs.
#include <gtest/gtest.h>

#include <algorithm>

#include "daemon/commands/replay.hpp"
#include "tests/support/run/bench_on_call.hpp"

namespace shaker::service {

using namespace test;
namespace {

using run::RunState;
constexpr auto off = recorded::KeptPictures::off;

class DrivenRecordingTest : public testing::Test {
protected:
    OnCallResult play(std::vector<Move> moves) {
        moves.push_back(until(in(RunState::idle)));
        run::RunOptions run = quick();
        run.drive.phi = 1.75;  // a slow walk
        return play_on_call(slow, run, folder_, std::move(moves));
    }
    std::function<void(BenchPort&)> give(OrderWhat what) { return orders(std::move(what), answers_); }
    std::filesystem::path file(const char* name) const { return folder_ / name; }

    std::filesystem::path folder_ = fresh_folder();
    Answers answers_;
};

// A measurement that was under way at the start is not in the file.
TEST_F(DrivenRecordingTest, CoversRunFromOrderToOrderAndReplays) {
    const auto r = play({{in(RunState::idle), give(Begin{10})},
                         {measured(2), give(Record{true, "middle", off})},
                         {measured(5), give(Record{false, "", off})},
                         {measured(7), give(End{})}});
    EXPECT_EQ(answers_, Answers(4, ""));
    const recorded::RecordingReader read{file("middle.nxs")};
    const auto all = recording::read_finished(read);
    ASSERT_GE(all.size(), 1U);
    EXPECT_LE(all.size(), 3U);
    const double from_s = static_cast<double>(read.play_times().front().tick.n) / read.header().dac.rate_hz;
    for (std::size_t i = 0; i < all.size(); ++i) {
        EXPECT_EQ(all[i].number, static_cast<int>(i) + 1);
        EXPECT_GT(all[i].part.from_s, from_s);
        EXPECT_NE(std::ranges::find(r.last.parts, all[i].part), r.last.parts.end());
    }
    EXPECT_EQ(read.damage(), std::vector<std::string>{});
    EXPECT_TRUE(commands::replay({.file = read.file()}));
    EXPECT_EQ(entered(r, RunState::ramp_down).size(), 1U) << "the drive went on\n" << log_of(r);
    EXPECT_NE(log_of(r).find("recorded from now on: middle.nxs"), std::string::npos);
}

// The first change of the drive in the file is older than its first sample.
TEST_F(DrivenRecordingTest, HasTheDriveThatWasInForce) {
    play({{in(RunState::idle), give(Begin{10})},
          {measured(2), give(Record{true, "middle", off})},
          {measured(4), give(End{})}});
    EXPECT_EQ(answers_, Answers(3, ""));
    const recorded::RecordingReader read{file("middle.nxs")};
    ASSERT_FALSE(read.changes().empty());
    EXPECT_LE(read.changes().front().end().n, read.play_times().front().tick.n);
    EXPECT_NE(read.changes().front().command.volts, Harmonics<Voltage>{});
    EXPECT_TRUE(commands::replay({.file = read.file()}));
}

TEST_F(DrivenRecordingTest, EndInFirstMeasurementKeepsItsWholePeriods) {
    const auto measuring = [](const BenchState& s) {
        return s.state == RunState::run && s.progress && s.progress->periods_done > 12;
    };
    const auto r = play({{in(RunState::idle), give(Record{true, "short", off})},
                         {in(RunState::idle), give(Begin{40})},
                         {measuring, give(Record{false, "", off})},
                         {measured(2), give(End{})}});
    EXPECT_EQ(answers_, Answers(4, ""));
    const recorded::RecordingReader read{file("short.nxs")};
    EXPECT_TRUE(recording::read_finished(read).empty());
    EXPECT_GT(read.scalar("process/reduced_to") - read.scalar("process/reduced_from"), 0.2);
    EXPECT_TRUE(commands::replay({.file = read.file()}));
    EXPECT_NEAR(r.last.parts[0].to_s - r.last.parts[0].from_s, 2, 1e-9)
        << "the run's own measurement is whole";
}

TEST_F(DrivenRecordingTest, SecondOneFollowsTheFirst) {
    const auto written = [](const BenchState& s) { return s.points.size() >= 3 && !s.recording.finishing; };
    play({{in(RunState::idle), give(Record{true, "first", off})},
          {in(RunState::idle), give(Begin{10})},
          {measured(2), give(Record{false, "", off})},
          {written, give(Record{true, "second", off})},
          {measured(5), give(Record{true, "third", off})},
          {measured(6), give(End{})}});
    ASSERT_EQ(answers_.size(), 6U);
    EXPECT_NE(answers_[4].find("recorded in second.nxs; end that recording first"), std::string::npos);
    for (const char* name : {"first.nxs", "second.nxs"})
        EXPECT_TRUE(commands::replay({.file = file(name)})) << name;
    EXPECT_FALSE(std::filesystem::exists(file("third.nxs")));
}

TEST_F(DrivenRecordingTest, RunThatEndsBeforeLeavesItToTheNext) {
    play({{in(RunState::idle), give(Begin{10})},
          {in(RunState::ramp), give(Record{true, "next", off})},
          {in(RunState::ramp), give(End{})},
          {in(RunState::idle), give(Begin{10})},
          {measured(1), give(End{})}});
    EXPECT_EQ(answers_, Answers(5, ""));
    EXPECT_TRUE(commands::replay({.file = file("next.nxs")}));
}

TEST_F(DrivenRecordingTest, AllPicturesNeedAStartAtRest) {
    run::RunOptions run = quick();
    run.pictures = recorded::KeptPictures::region;
    play_on_call(slow, run, folder_,
                 {{in(RunState::idle), give(Begin{10})},
                  {measured(1), give(Record{true, "x", recorded::KeptPictures::region})},
                  {measured(1), give(End{})},
                  until(in(RunState::idle))});
    ASSERT_EQ(answers_.size(), 3U);
    EXPECT_NE(answers_[1].find("pictures \"region\" can be recorded only from the start of a run"),
              std::string::npos)
        << answers_[1];
}

}  // namespace
}  // namespace shaker::service
