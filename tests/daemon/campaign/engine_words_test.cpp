// Words, trips and full recordings at any moment of a campaign: its journal can be read after every event, no
// measurement is lost or counted twice, and a pause ends every drive.
#include <gtest/gtest.h>
#include <spdlog/fmt/fmt.h>

#include <random>

#include "daemon/campaign/progress.hpp"
#include "drivers/errors.hpp"
#include "tests/support/campaign/engine_bench.hpp"

namespace shaker::campaign {
namespace {

/// The journal of a bench's events, read again after each one.
class ReadBack {
public:
    ReadBack() { follower_({"t", CampaignChange{CampaignChange::What::begun, "", "plan"}}); }
    /// Empty, or what the reader says of the newest events.
    std::string read(const std::vector<Event>& events) {
        for (; read_ < events.size(); ++read_) follower_({"t", events[read_]});
        return fmt::format("{}", fmt::join(follower_.progress().remarks, "; "));
    }
    [[nodiscard]] const Progress& progress() const { return follower_.progress(); }

private:
    Follower follower_;
    std::size_t read_ = 0;
};

std::vector<Point> three_points(int periods = 20) {
    return {point(1, 0.7, 0, periods), point(2, 0.7, 3, periods), point(3, 0.5, 0, periods)};
}

// Pause in point 2, then skip, repeat, skip: the second skip is of a point that was not begun again.
TEST(EngineWordsTest, SkipOfARepeatedPointIsReadBack) {
    Engine engine{three_points(), {}};
    EngineBench bench{0.15, 0};
    bench.say(3.5, Word::pause);
    for (const auto& [when, word] : {std::pair{4.0, Word::skip}, {4.1, Word::repeat}, {4.2, Word::skip}})
        bench.say(when, word);
    bench.say(5, Word::resume);
    bench.play(engine);
    ReadBack journal;
    EXPECT_EQ(journal.read(bench.events), "");
    EXPECT_TRUE(engine.done());
}

// A trip between the end of a measurement and its reduction: the pass is reported once, and counts.
TEST(EngineWordsTest, TripBeforeTheReductionLosesNothing) {
    for (double trip_s = 2.5; trip_s < 5; trip_s += dt_s) {
        Engine engine{three_points(), {}};
        EngineBench bench{0.15, 0};
        bench.reduction_s = 0.3;
        bench.trip_at(trip_s, trip_s + 1);
        bench.say(trip_s + 2, Word::resume);
        bench.play(engine);
        ReadBack journal;
        EXPECT_EQ(journal.read(bench.events), "") << "trip at " << trip_s;
        std::size_t counted = 0;
        for (const auto& [id, p] : journal.progress().points) {
            EXPECT_EQ(p.ended->outcome, Outcome::measured);
            for (const PassEnded& pass : p.passes) counted += pass.measurement > 0;
        }
        EXPECT_EQ(counted, static_cast<std::size_t>(bench.measurements())) << "trip at " << trip_s;
    }
}

// A pass that a recording cannot hold is cut, and the point is measured in several recordings.
TEST(EngineWordsTest, LongPointTakesSeveralRecordings) {
    Engine engine{{point(1, 0.5, 0, 1200)}, {.timing = {.recording_s = 25}}};
    EngineBench bench{1000, 0};
    bench.start_s = 6;
    bench.recording_s = 25;
    bench.play(engine);
    ReadBack journal;
    EXPECT_EQ(journal.read(bench.events), "");
    const PointProgress& p = journal.progress().points.at(1);
    ASSERT_EQ(p.ended->outcome, Outcome::measured) << p.ended->reason;
    EXPECT_GE(p.passes.size(), 4U);
    for (const PassEnded& pass : p.passes) EXPECT_EQ(pass.how, PassEnded::How::complete) << pass.reason;
}

TEST(EngineWordsTest, RecordingThatIsFullEarlyKeepsWhatItHas) {
    Engine engine{{point(1, 0.5, 0, 400)}, {}};  // does not know of the limit
    EngineBench bench{1000, 0};
    bench.recording_s = 12;
    bench.reduction_s = 0.3;
    bench.play(engine);
    ReadBack journal;
    EXPECT_EQ(journal.read(bench.events), "");
    const PointProgress& p = journal.progress().points.at(1);
    ASSERT_EQ(p.ended->outcome, Outcome::measured) << p.ended->reason;
    EXPECT_EQ(p.passes.front().how, PassEnded::How::early);
    EXPECT_EQ(p.passes.front().reason, "the drive ended before the pass was complete");
}

// A pause ends the drive in the step in which it is given, whatever the bench does.
TEST(EngineWordsTest, PauseEndsTheDriveInEveryState) {
    for (double when = 0.2; when < 12; when += dt_s) {
        Engine engine{three_points(), {}};
        EngineBench bench{0.15, 0};
        bench.start_s = 1, bench.stop_s = 0.5, bench.reduction_s = 0.3;
        bench.play(engine, when);
        if (engine.done()) break;
        engine.obey(Word::pause);
        bench.step(engine);
        EXPECT_TRUE(bench.state() == run::RunState::ramp_down || !run::driving(bench.state()))
            << "pause at " << when << ", state " << run::name(bench.state());
    }
}

// Random words, trips, full recordings and failing reductions.
TEST(EngineWordsTest, RandomWordsLeaveAJournalThatIsRead) {
    constexpr std::array words{Word::pause,  Word::resume, Word::skip,
                               Word::repeat, Word::resume, Word::resume};
    std::size_t done = 0, counted = 0, obeyed = 0;
    for (unsigned seed = 1; seed <= 500; ++seed) {
        std::mt19937_64 random{seed};
        std::uniform_real_distribution<double> unit{0, 1};
        Engine engine{three_points(10 + static_cast<int>(30 * unit(random))), {}};
        EngineBench bench{0.05 + 0.1 * unit(random), 0};
        bench.start_s = unit(random), bench.stop_s = 0.5 * unit(random);
        bench.reduction_s = 0.5 * unit(random);
        if (seed % 4 == 0) bench.recording_s = 3 + 6 * unit(random);
        ReadBack journal;
        double trip_s = 0;
        while (!engine.done() && bench.now_s_ < 120) {
            if (unit(random) < 0.03 && bench.now_s_ < 30) try {
                    engine.obey(words.at(static_cast<std::size_t>(unit(random) * words.size())));
                    ++obeyed;
                } catch (const InputError&) {  // it has no meaning now
                }
            if (bench.now_s_ > 30 && engine.paused() && bench.state() == run::RunState::idle)
                engine.obey(Word::resume);
            if (bench.now_s_ > trip_s && bench.now_s_ < 30) {
                trip_s = bench.now_s_ + 10 * unit(random);
                bench.trip_at(trip_s, trip_s + unit(random));
            }
            bench.fails = unit(random) < 0.02;
            bench.step(engine);
            bench.now_s_ += dt_s;
            ASSERT_EQ(journal.read(bench.events), "") << "seed " << seed << " at " << bench.now_s_;
        }
        done += engine.done() ? 1 : 0;
        for (const auto& [id, p] : journal.progress().points) {
            if (engine.done()) {
                ASSERT_TRUE(p.ended) << "seed " << seed << ", point " << id;
            }
            counted += p.ended && p.ended->outcome == Outcome::measured ? 1 : 0;
        }
    }
    EXPECT_GT(done, 490U);
    EXPECT_GT(counted, 500U);
    EXPECT_GT(obeyed, 2000U);
}

}  // namespace
}  // namespace shaker::campaign
