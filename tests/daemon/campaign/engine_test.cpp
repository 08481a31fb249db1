// The engine on a played bench: a walker that drifts as the exact law says, settles and is measured in no
// time.
#include "daemon/campaign/engine.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>
#include <random>

#include "daemon/campaign/progress.hpp"
#include "drivers/errors.hpp"

namespace shaker::campaign {
namespace {

constexpr double dt_s = 0.05;    // a period
constexpr int runs_on = 3;       // periods from an order until it is in force: the walker goes on as before
constexpr double margin = 2e-3;  // m, from the end of the way to the limit at the edge

/// Plays the bench in steps of one period.
class PlayedBench {
public:
    PlayedBench(double length_m, double x_m, double mu = 0.113)
        : length_m_{length_m}, x_m_{x_m}, walks_{mu} {}

    /// Leads the engine to its end, or until `limit_s`.
    void play(Engine& engine, double limit_s = 3600) {
        for (; !engine.done() && now_s_ < limit_s; now_s_ += dt_s) {
            Action action;
            for (const auto& [when, word] : words_)
                if (now_s_ >= when && now_s_ < when + dt_s) engine.obey(word);
            if (trip_at_s_ <= now_s_) trip();
            if (clear_at_s_ <= now_s_ && state_ == run::RunState::tripped) {
                state_ = run::RunState::idle;
                clear_at_s_ = INFINITY;
            }
            action = engine.next(seen());
            obey(action, engine);
            move(engine);
            for (Event& e : engine.events()) events.push_back(std::move(e));
        }
    }
    void trip_at(double s, double clear_s) { trip_at_s_ = s, clear_at_s_ = clear_s; }
    void say(double s, Word word) { words_.emplace_back(s, word); }

    std::vector<Event> events;
    double now_s_ = 0;
    int edges = 0;  // times that the walker was beyond the limit at the edge
    int starts = 0;
    bool fails = false;  // no measurement can be reduced
    double free_bytes = INFINITY;

private:
    [[nodiscard]] Seen seen() const {
        return {.now_s = now_s_,
                .state = state_,
                .may_start = state_ == run::RunState::idle,
                .holding = state_ == run::RunState::run && left_ == 0,
                .recorded_s = now_s_ - started_s_,
                .free_bytes = free_bytes,
                .x_m = x_m_,
                .way = {x_m_ + length_m_ / 2, length_m_ / 2 - x_m_}};
    }
    void trip() {
        trip_at_s_ = INFINITY;
        state_ = run::RunState::tripped;
        left_ = 0, measured_s_ = 0;
    }
    void obey(const Action& action, Engine& engine) {
        if (const auto* start = std::get_if<Start>(&action)) {
            ++starts;
            started_s_ = now_s_;
            aim(start->drive, start->task);
        } else if (const auto* change = std::get_if<Change>(&action)) {
            if (measured_s_ > 7 * dt_s) give(engine);
            aim(change->drive, change->task);
        } else if (std::holds_alternative<Stop>(action)) {
            if (measured_s_ > 7 * dt_s) give(engine);
            state_ = run::RunState::idle;
            measured_s_ = 0;
        }
    }
    [[nodiscard]] const Drive& played() const { return now_s_ < runs_on_s_ - 1e-9 ? before_ : drive_; }
    void aim(const Drive& drive, const run::Task& task) {
        if (state_ == run::RunState::run) before_ = played(), runs_on_s_ = now_s_ + runs_on * dt_s;
        state_ = run::RunState::run;
        drive_ = drive;
        task_ = task;
        left_ = task.plan.periods == 0 ? 0 : task.plan.measurements;
        settled_s_ = now_s_ + dt_s * (1 + std::max(25, walks_.at(drive).settling));
        measured_s_ = 0;
    }
    void move(Engine& engine) {
        if (state_ != run::RunState::run) return;
        x_m_ += walks_.at(played()).v_D * dt_s;
        if (std::abs(x_m_) > length_m_ / 2 + margin) ++edges;
        if (left_ == 0 || now_s_ < settled_s_) return;
        measured_s_ += dt_s;
        if (measured_s_ < (task_.plan.periods + 2) * dt_s - 1e-9) return;
        give(engine);
        --left_;
        measured_s_ = 0;
    }
    void give(Engine& engine) {
        on_call::Measured m;
        const int whole = std::min(task_.plan.periods, static_cast<int>(measured_s_ / dt_s + 1e-9) - 2);
        m.measurement.number = ++number_;
        m.measurement.asked = drive_;
        m.measurement.part = {now_s_ - whole * dt_s, now_s_};
        m.recording = "r001.nxs";
        if (fails) {
            m.not_reduced = "no walker";
        } else {
            auto r = std::make_shared<reduction::Reduction>();
            r->v_D = {walks_.at(drive_).v_D, 1e-4 / std::sqrt(whole)};
            m.reduction = r;
        }
        engine.take(m);
    }

    double length_m_, x_m_;
    WalkPredictor walks_;
    run::RunState state_ = run::RunState::idle;
    Drive drive_, before_;
    double runs_on_s_ = 0;  // before_ is in force until then
    run::Task task_;
    int left_ = 0, number_ = 0;
    double settled_s_ = 0, measured_s_ = 0, started_s_ = 0;
    double trip_at_s_ = INFINITY, clear_at_s_ = INFINITY;
    std::vector<std::pair<double, Word>> words_;
};

Point point(int id, double gamma_g, double phi, int periods = 40) {
    Point p{.id = id, .series = "s", .asked = {}, .repeat = 1, .partner = 0};
    p.asked.drive.gamma = gamma_g * paper_g;
    p.asked.drive.phi = phi;
    p.asked.plan.periods = periods;
    return p;
}

template <class T>
std::vector<T> all(const std::vector<Event>& events) {
    std::vector<T> found;
    for (const Event& e : events)
        if (const auto* t = std::get_if<T>(&e)) found.push_back(*t);
    return found;
}

std::vector<int> outcomes(const std::vector<Event>& events, Outcome outcome) {
    std::vector<int> ids;
    for (const PointEnded& e : all<PointEnded>(events))
        if (e.outcome == outcome) ids.push_back(e.point);
    return ids;
}

int periods(const PassEnded& pass) { return static_cast<int>(std::lround((pass.to_s - pass.from_s) * 20)); }

TEST(EngineTest, MeasuresPointsByLiveChanges) {
    Engine engine{{point(1, 1, 0), point(2, 1, std::numbers::pi), point(3, 0.7, 1)}, {}};
    PlayedBench bench{0.15, 0};
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
    PlayedBench bench{0.14, 0};
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
    PlayedBench bench{0.06, 0};
    bench.play(engine);
    const auto failed = all<PointEnded>(bench.events).front();
    EXPECT_EQ(failed.outcome, Outcome::failed);
    EXPECT_NE(failed.reason.find("the free way is"), std::string::npos) << failed.reason;
    EXPECT_EQ(outcomes(bench.events, Outcome::measured), std::vector{2});
}

TEST(EngineTest, WrongMuEndsPassBeforeTheEdge) {
    Engine engine{{point(1, 2, 0), point(2, 2, std::numbers::pi)}, {.mu = 0.15}};
    PlayedBench bench{0.13, -0.05, 0.09};
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
    PlayedBench bench{0.15, 0};
    bench.play(engine);
    int sum = 0;
    for (const PassEnded& pass : all<PassEnded>(bench.events)) sum += periods(pass);
    EXPECT_NEAR(sum, 100, 5);
}

TEST(EngineTest, FailedPointIsTriedAgainOnceThenLeftOut) {
    Engine engine{{point(1, 0.7, 0)}, {}};
    PlayedBench bench{0.15, 0};
    bench.fails = true;
    bench.play(engine);
    EXPECT_EQ(all<PassEnded>(bench.events).size(), 2U);
    ASSERT_EQ(outcomes(bench.events, Outcome::failed), std::vector{1});
    EXPECT_EQ(all<PointEnded>(bench.events).front().reason, "no walker");
}

TEST(EngineTest, TripPausesUntilClearAndResume) {
    Engine engine{{point(1, 0.7, 0), point(2, 0.7, 1)}, {}};
    PlayedBench bench{0.15, 0};
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
    PlayedBench bench{0.15, 0};
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
    PlayedBench bench{0.15, 0};
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
    PlayedBench bench{0.15, 0};
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
    PlayedBench bench{0.15, 0};
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
    PlayedBench bench{0.15, 0};
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
    PlayedBench bench{0.14, 0};
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
    PlayedBench bench{0.15, 0};
    bench.play(engine);
    EXPECT_EQ(outcomes(bench.events, Outcome::measured), std::vector{2});
}

TEST(EngineTest, NewFrequencyIsANewRecording) {
    Point other = point(2, 0.7, 0);
    other.asked.drive.frequency = 25;
    Engine engine{{point(1, 0.7, 0), other, point(3, 0.7, 1)}, {}};
    PlayedBench bench{0.15, 0};
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
        PlayedBench bench{length_m, (unit(random) - 0.5) * length_m};
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
