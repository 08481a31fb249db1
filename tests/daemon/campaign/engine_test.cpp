// The engine on a played bench: a walker that drifts as the exact law says, settles and is measured in no
// time.
#include "daemon/campaign/engine.hpp"

#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "daemon/campaign/progress.hpp"
#include "daemon/reduction/spread/drift_spread.hpp"
#include "drivers/errors.hpp"
#include "tests/support/campaign/engine_bench.hpp"
#include "tests/support/nightly.hpp"

namespace shaker::campaign {
namespace {

std::vector<int> outcomes(const std::vector<Event>& events, Outcome outcome) {
    std::vector<int> ids;
    for (const PointEnded& e : all<PointEnded>(events))
        if (e.outcome == outcome) ids.push_back(e.point);
    return ids;
}

int periods(const PassEnded& pass) { return static_cast<int>(std::lround((pass.to_s - pass.from_s) * 20)); }

TEST(EngineTest, MeasuresPointsByLiveChanges) {
    Engine engine{{point(1, 1, 0), point(2, 1, std::numbers::pi), point(3, 0.7, 1)}, {}};
    EngineBench bench{0.15, 0};
    bench.play(engine);
    EXPECT_TRUE(engine.done());
    EXPECT_EQ(outcomes(bench.events, Outcome::measured), (std::vector{1, 2, 3}));
    EXPECT_EQ(bench.starts, 1) << "one recording";
    for (const PassEnded& pass : all<PassEnded>(bench.events)) {
        EXPECT_EQ(pass.how, PassEnded::How::complete);
        EXPECT_EQ(periods(pass), 40);
    }
    EXPECT_EQ(bench.edges, 0);
}

TEST(EngineTest, WalkerReturnsForPassesOfOnePoint) {
    Engine engine{{point(1, 3, 0, 60)}, {}};  // 57 mm/s: 60 periods are 171 mm
    EngineBench bench{0.14, 0};
    bench.play(engine);
    EXPECT_EQ(outcomes(bench.events, Outcome::measured), std::vector{1});
    const auto passes = all<PassEnded>(bench.events);
    EXPECT_GT(passes.size(), 1U);
    int sum = 0;
    for (const PassEnded& pass : passes) sum += periods(pass);
    EXPECT_GE(sum, 60);
    EXPECT_LE(sum, 64);
    EXPECT_EQ(bench.edges, 0);
}

TEST(EngineTest, PointThatCannotFitFailsByName) {
    Engine engine{{point(1, 3, 0), point(2, 0.7, 0)}, {}};
    EngineBench bench{0.06, 0};
    bench.play(engine);
    const auto failed = all<PointEnded>(bench.events).front();
    EXPECT_EQ(failed.outcome, Outcome::failed);
    EXPECT_NE(failed.reason.find("the free way is"), std::string::npos) << failed.reason;
    EXPECT_EQ(outcomes(bench.events, Outcome::measured), std::vector{2});
}

TEST(EngineTest, WrongMuEndsPassBeforeTheEdge) {
    Engine engine{{point(1, 2, 0), point(2, 2, std::numbers::pi)}, {.mu = 0.15}};
    EngineBench bench{0.13, -0.05, 0.09};
    bench.play(engine);
    EXPECT_EQ(bench.edges, 0);
    EXPECT_EQ(outcomes(bench.events, Outcome::measured).size(), 2U);
}

TEST(EngineTest, PrecisionDecidesThePeriods) {
    Point p = point(1, 0.7, 1);
    p.asked.precision = 1e-5;  // of 1e-4 / sqrt(periods)
    p.asked.least_periods = 20;
    p.asked.most_periods = 400;
    Engine engine{{p}, {}};
    EngineBench bench{0.15, 0};
    bench.play(engine);
    int sum = 0;
    for (const PassEnded& pass : all<PassEnded>(bench.events)) sum += periods(pass);
    EXPECT_NEAR(sum, 100, 5);
}

// What the points table computes from the recordings must keep what the engine stopped for.
TEST(EngineTest, CombinedErrorKeepsThePrecisionOrThePointTellsWhy) {
    constexpr int points = 200;
    std::mt19937_64 draw(test::seed_of_day(1));
    std::normal_distribution<double> normal;
    std::vector<Point> asked;
    for (int id = 1; id <= points; ++id) {
        Point& p = asked.emplace_back(point(id, 0.7, 1));
        p.asked.precision = std::exp(std::uniform_real_distribution(-1.0, 1.0)(draw)) * 2e-5;
        p.asked.least_periods = 10;
        p.asked.most_periods = 100;
    }
    Engine engine{asked, {}};
    EngineBench bench{0.15, 0};
    std::vector<calibration::Estimate> given;
    bench.result = [&](double v_D, int periods) {
        const double sigma = 1e-4 / std::sqrt(periods);
        double squares = 0;
        for (int i = 1; i < periods; ++i) squares += std::pow(normal(draw), 2) / (periods - 1);
        return given.emplace_back(
            calibration::Estimate{v_D + sigma * normal(draw),
                                  sigma * std::sqrt(squares) * reduction::few_periods_factor(periods - 1)});
    };
    bench.play(engine);
    std::map<int, std::vector<reduction::PassDrift>> passes;
    for (const PassEnded& pass : all<PassEnded>(bench.events))
        passes[pass.point].push_back(
            {given.at(static_cast<std::size_t>(pass.measurement - 1)), periods(pass)});
    int within = 0, told = 0;
    for (const PointEnded& end : all<PointEnded>(bench.events)) {
        const double error = reduction::combined(passes[end.point]).v_D.sigma,
                     precision = asked[static_cast<std::size_t>(end.point - 1)].asked.precision;
        within += error <= precision;
        told += end.reason.find("the most that the plan allows") != std::string::npos;
        EXPECT_NE(error <= precision, end.reason.find("was asked") != std::string::npos)
            << "point " << end.point << ": " << error << " for " << precision << "; " << end.reason;
    }
    std::printf("%d points: %d within their precision, %d name the largest number of periods\n", points,
                within, told);
    EXPECT_EQ(within + told, points);
    EXPECT_GT(told, 0);
}

TEST(EngineTest, FailedPointIsTriedAgainOnceThenLeftOut) {
    Engine engine{{point(1, 0.7, 0)}, {}};
    EngineBench bench{0.15, 0};
    bench.fails = true;
    bench.play(engine);
    EXPECT_EQ(all<PassEnded>(bench.events).size(), 2U);
    ASSERT_EQ(outcomes(bench.events, Outcome::failed), std::vector{1});
    EXPECT_EQ(all<PointEnded>(bench.events).front().reason, "no walker");
}

TEST(EngineTest, TripPausesUntilClearAndResume) {
    Engine engine{{point(1, 0.7, 0), point(2, 0.7, 1)}, {}};
    EngineBench bench{0.15, 0};
    bench.trip_at(1, 5);
    bench.say(10, Word::resume);
    bench.play(engine, 9);
    EXPECT_TRUE(engine.paused());
    EXPECT_EQ(bench.starts, 1) << "cleared, but not resumed";
    bench.play(engine);
    EXPECT_EQ(outcomes(bench.events, Outcome::measured), (std::vector{1, 2}));
    EXPECT_EQ(all<CampaignChange>(bench.events).size(), 2U);
    EXPECT_EQ(all<PassEnded>(bench.events).front().how, PassEnded::How::failed);
}

TEST(EngineTest, ResumeIsRefusedBeforeTheTripIsCleared) {
    Engine engine{{point(1, 0.7, 0)}, {}};
    EngineBench bench{0.15, 0};
    bench.trip_at(1, 100);
    bench.play(engine, 3);
    EXPECT_THROW(engine.obey(Word::resume), InputError);
}

// The identification walks some millimetres in a direction that nobody knows: near the edge the walker is led
// to the middle first.
TEST(EngineTest, LeadsFromTheEdgeBeforeTheIdentification) {
    Engine engine{{point(1, 0.4, 0)}, {}};
    Seen seen{.state = run::RunState::idle, .may_start = true, .identified = false, .way = {0.08, 0.004}};
    const Action first = engine.next(seen);
    ASSERT_TRUE(std::holds_alternative<Start>(first));
    EXPECT_EQ(std::get<Start>(first).task.plan.periods, 0) << "a move";
    EXPECT_EQ(std::get<Start>(first).drive.phi, std::numbers::pi) << "towards -x";
    seen.state = run::RunState::run;
    seen.way = {0.04, 0.044};
    EXPECT_TRUE(std::holds_alternative<Stop>(engine.next(seen)));
    seen.state = run::RunState::idle;
    const Action second = engine.next(seen);
    ASSERT_TRUE(std::holds_alternative<Start>(second));
    EXPECT_EQ(std::get<Start>(second).task.plan.periods, 40);
}

// The bench, not the point, is the reason: however often it refuses, no point is given up.
TEST(EngineTest, RefusedStartPausesAndCountsAsNoTry) {
    Engine engine{{point(1, 0.7, 0)}, {}};
    const Seen idle{.state = run::RunState::idle, .may_start = true};
    for (int i = 0; i < 5; ++i) {
        EXPECT_TRUE(std::holds_alternative<Start>(engine.next(idle)));
        engine.refused("no picture of the walker");
        EXPECT_TRUE(engine.paused());
        EXPECT_TRUE(std::holds_alternative<std::monostate>(engine.next(idle)));
        engine.obey(Word::resume);
    }
    EXPECT_TRUE(all<PointEnded>(engine.events()).empty());
}

TEST(EngineTest, SkipPauseAndStop) {
    Engine engine{{point(1, 0.7, 0), point(2, 0.7, 1), point(3, 0.7, 2), point(4, 0.7, 3)}, {}};
    EngineBench bench{0.15, 0};
    bench.say(1, Word::skip);
    bench.say(2, Word::pause);
    bench.say(6, Word::resume);
    bench.say(7, Word::stop);
    bench.play(engine);
    EXPECT_TRUE(engine.done());
    EXPECT_EQ(outcomes(bench.events, Outcome::left_out), std::vector{1});
    EXPECT_EQ(outcomes(bench.events, Outcome::measured), std::vector{2}) << "stop is after this point";
}

TEST(EngineTest, RepeatMeasuresTheLastPointAgainAndSaysSo) {
    Engine engine{{point(1, 0.7, 0), point(2, 0.7, 1), point(3, 0.7, 2)}, {}};
    EngineBench bench{0.15, 0};
    EXPECT_THROW(engine.obey(Word::repeat), InputError);
    bench.say(6, Word::repeat);  // while point 2 is measured
    bench.play(engine);
    EXPECT_EQ(outcomes(bench.events, Outcome::measured), (std::vector{1, 2, 1, 3}));
    const auto lost = all<PassLost>(bench.events);
    ASSERT_EQ(lost.size(), 1U);
    EXPECT_EQ(lost.front().point, 1);
    EXPECT_EQ(lost.front().reason, "repeated by the operator");
    std::vector<JournalEntry> entries{{"t", CampaignChange{CampaignChange::What::begun, "", "plan"}}};
    for (const Event& e : bench.events) entries.push_back({"t", e});
    EXPECT_EQ(progress_of(entries).points.at(1).passes.size(), 1U) << "the journal can be followed";
}

TEST(EngineTest, MeasurementOfASkippedPointCountsForNoOther) {
    Engine engine{{point(1, 0.7, 0), point(2, 0.7, 1)}, {}};
    EngineBench bench{0.15, 0};
    bench.say(2.5, Word::skip);  // has whole periods already
    bench.play(engine);
    EXPECT_EQ(outcomes(bench.events, Outcome::left_out), std::vector{1});
    const auto passes = all<PassEnded>(bench.events);
    ASSERT_EQ(passes.size(), 1U);
    EXPECT_EQ(passes.front().point, 2);
    EXPECT_EQ(periods(passes.front()), 40);
}

TEST(EngineTest, FullDiskPausesBeforeThePoint) {
    Engine engine{{point(1, 0.7, 0), point(2, 0.7, 1)}, {}};
    EngineBench bench{0.15, 0};
    bench.free_bytes = 110e6;
    bench.play(engine, 10);
    EXPECT_TRUE(engine.paused());
    EXPECT_EQ(bench.starts, 0);
    const auto pauses = all<CampaignChange>(bench.events);
    ASSERT_EQ(pauses.size(), 1U);
    EXPECT_NE(pauses.front().reason.find("110 MB left and point 1"), std::string::npos)
        << pauses.front().reason;
    bench.free_bytes = 1e12;
    engine.obey(Word::resume);
    bench.play(engine);
    EXPECT_EQ(outcomes(bench.events, Outcome::measured).size(), 2U);
}

TEST(EngineTest, ReturnsAreNotedWithTheirAccuracy) {
    Engine engine{{point(1, 3, 0, 200)}, {}};
    EngineBench bench{0.14, 0};
    bench.play(engine);
    const auto returns = all<Returned>(bench.events);
    ASSERT_GT(returns.size(), 2U);
    for (const Returned& r : returns) {
        EXPECT_EQ(r.point, 1);
        EXPECT_LT(r.x_to_m, r.x_from_m) << "against the drift";
        EXPECT_GT(r.for_s, 0);
    }
    EXPECT_NEAR(returns.back().x_to_m, returns.back().x_asked_m, 3e-3);
}

TEST(EngineTest, EndedPointsAreNotMeasuredAgain) {
    Engine engine{{point(1, 0.7, 0), point(2, 0.7, 1)}, {}, {1}};
    EngineBench bench{0.15, 0};
    bench.play(engine);
    EXPECT_EQ(outcomes(bench.events, Outcome::measured), std::vector{2});
}

TEST(EngineTest, NewFrequencyIsANewRecording) {
    Point other = point(2, 0.7, 0);
    other.asked.drive.frequency = 25;
    Engine engine{{point(1, 0.7, 0), other, point(3, 0.7, 1)}, {}};
    EngineBench bench{0.15, 0};
    bench.play(engine);
    EXPECT_EQ(bench.starts, 3);
}

// Random plans in random views: the walker never leaves its way, and every point ends with a name.
TEST(EngineTest, RandomPlansStayInView) {
    std::mt19937_64 random{1};
    std::uniform_real_distribution<double> unit{0, 1};
    int measured = 0, failed = 0;
    for (int k = 0; k < 60; ++k) {
        std::vector<Point> points;
        for (int i = 1; i <= 8; ++i)
            points.push_back(point(i, 0.15 + 2.85 * unit(random), two_pi * unit(random)));
        const double length_m = 0.05 + 0.1 * unit(random);
        Engine engine{points, {}};
        EngineBench bench{length_m, (unit(random) - 0.5) * length_m};
        bench.play(engine, 3000);
        EXPECT_TRUE(engine.done()) << "plan " << k;
        EXPECT_EQ(bench.edges, 0) << "plan " << k;
        EXPECT_EQ(all<PointEnded>(bench.events).size(), 8U) << "plan " << k;
        measured += static_cast<int>(outcomes(bench.events, Outcome::measured).size());
        for (const PointEnded& e : all<PointEnded>(bench.events))
            if (e.outcome == Outcome::failed) {
                ++failed;
                EXPECT_NE(e.reason.find("free way"), std::string::npos) << e.reason;
            }
    }
    EXPECT_GT(measured, failed);
}

}  // namespace
}  // namespace shaker::campaign
