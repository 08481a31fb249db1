// Runs that end after a number of measurements; the expected duration and walk of a run, and its progress.
#include <gtest/gtest.h>
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "daemon/safety/preflight.hpp"
#include "daemon/service/outlook.hpp"
#include "tests/support/nightly.hpp"
#include "tests/support/run/bench_on_call.hpp"

namespace shaker::service {
namespace {

using run::RunState;
using test::Answers;
using test::in;
using test::until;

class CountedRunTest : public test::OnCallBench {
protected:
    [[nodiscard]] test::Move start_counted(int times, int periods = 10) {
        return {in(RunState::idle), give(Begin{{.periods = periods, .measurements = times}})};
    }
};

TEST_F(CountedRunTest, EndsSoftlyAfterItsMeasurements) {
    options.drive.phi = 1.75;
    const auto r = play(test::slow, {start_counted(3), until(in(RunState::run)), until(in(RunState::idle))});
    EXPECT_EQ(answers, Answers(1, ""));
    EXPECT_EQ(r.last.points.size(), 3U) << test::log_of(r);
    EXPECT_EQ(r.last.trips, 0U);
    EXPECT_EQ(test::entered(r, RunState::ramp_down).size(), 1U) << test::log_of(r);
    EXPECT_TRUE(std::ranges::any_of(
        r.events, [](const BenchEvent& e) { return e.text == "3 measurements are complete"; }));
}

TEST_F(CountedRunTest, NewSetPointStartsTheCountAgain) {
    options.drive.phi = 1.75;
    Drive other = options.drive;
    other.phi = 1.7;
    const auto r = play(test::slow, {start_counted(2),
                                     {test::measured(1), give(SetDrive{other})},
                                     until(in(RunState::ramp_down)),
                                     until(in(RunState::idle))});
    EXPECT_EQ(answers, Answers(2, ""));
    EXPECT_EQ(std::ranges::count_if(r.last.points, [](const auto& p) { return p.asked.phi == 1.7; }), 2)
        << test::log_of(r);
}

TEST_F(CountedRunTest, CountIsChecked) {
    play(test::slow, {start_counted(-1)}, 10);
    ASSERT_EQ(answers.size(), 1U);
    EXPECT_NE(answers[0].find("measurements -1: 0 to 100000 is allowed"), std::string::npos) << answers[0];
}

// The walk at phi 0 is 14.6 mm/s, and 5 mm are left at each edge of the picture.
TEST_F(CountedRunTest, OutlookAndProgressAgreeWithTheRun) {
    BenchState before, under_way, settles;
    const auto keep = [](BenchState& to, std::function<bool(const BenchState&)> when) {
        return [&to, when = std::move(when)](const BenchState& s) {
            if (when(s)) to = s;
            return when(s);
        };
    };
    std::string scene = test::slow;
    scene += "[walker]\nstart_mm = -30\n";
    const auto r = play(
        scene,
        {{keep(before, in(RunState::idle)), give(Begin{{.periods = 20, .measurements = 2}})},
         until(keep(settles, [](const BenchState& s) { return s.state == RunState::run && !s.measuring; })),
         until(keep(under_way, [](const BenchState& s) { return s.measuring && s.points.size() == 1; })),
         until(in(RunState::idle))},
        60, {0.113, 0.001});
    EXPECT_EQ(answers, Answers(1, ""));
    ASSERT_TRUE(before.outlook.walk);
    EXPECT_NEAR(1e3 * before.outlook.walk->v_D.value, 14.6, 0.3);
    const double swing_m = safety::largest_displacement(harmonics(before.wanted), before.wanted.frequency);
    EXPECT_NEAR(1e3 * before.outlook.way_m, 1e3 * (before.walker->ways_m[1] - swing_m), 0.1);
    EXPECT_FALSE(before.progress);
    ASSERT_TRUE(settles.progress);
    EXPECT_FALSE(settles.progress->waits_for.empty());
    ASSERT_TRUE(under_way.progress);
    EXPECT_EQ(under_way.progress->measurement, 2);
    EXPECT_EQ(under_way.progress->measurements, 2);
    EXPECT_EQ(under_way.progress->waits_for, "");
    EXPECT_NEAR(under_way.progress->left_s, (20 - under_way.progress->periods_done) / 20, 0.06);
    EXPECT_NEAR(1e3 * under_way.progress->walk_mps, 14.6, 0.3);
    EXPECT_NEAR(under_way.progress->periods_left, 1e3 * under_way.walker->ways_m[1] / 0.73, 3);
    const double run_s = test::entered(r, RunState::ramp_down).front() - before.now_s;
    EXPECT_NEAR((before.outlook.before + 40) / 20.0, run_s, 0.35 * run_s) << "expected before the start";
    const double gone_mm = 1e3 * (r.last.walker->x_m - before.walker->x_m);
    EXPECT_NEAR(14.6 * (before.outlook.walking + 40) / 20.0, gone_mm, 0.35 * gone_mm);
}

// N measurements end softly where the way to the edge ends: no trip, from any place, at any length. The first
// one keeps its whole periods when the way ends in it.
TEST_F(CountedRunTest, EndsSoftlyWhereTheWayEnds) {
    std::mt19937_64 draw{test::seed_of_day(5)};
    const auto between = [&](int least, int most) {
        return std::uniform_int_distribution{least, most}(draw);
    };
    int in_one = 0, before_next = 0, all = 0;
    const int runs = test::plays(8, 100);
    for (int i = 0; i < runs; ++i) {
        const int times = between(1, 5), periods = between(10, 80), start_mm = between(-40, 40);
        options.drive.gamma = paper_g * (0.7 + 0.1 * between(0, 8));
        options.drive.phi = between(0, 1) * std::numbers::pi;
        std::string scene = test::slow;
        scene += fmt::format("[walker]\nstart_mm = {}\n", start_mm);
        const std::string what = fmt::format("{} x {} periods from {} mm, gamma {:.3g}, phi {:.3g}", times,
                                             periods, start_mm, options.drive.gamma, options.drive.phi);
        const auto r = play(
            scene, {start_counted(times, periods), until(in(RunState::ramp_down)), until(in(RunState::idle))},
            60, {0.113, 0.001});
        ASSERT_EQ(answers, Answers(1, "")) << what;
        EXPECT_EQ(r.last.trips, 0U) << what << "\n" << test::log_of(r);
        const int measured = static_cast<int>(r.last.points.size());
        const auto logged = [&](const std::string& begin) {
            return std::ranges::any_of(r.events,
                                       [&](const BenchEvent& e) { return e.text.starts_with(begin); });
        };
        if (logged(fmt::format("{} measurements are complete", times))) {
            EXPECT_EQ(measured, times) << what;
            ++all;
        } else if (logged(fmt::format("stopped after {} of {}: the next", measured, times))) {
            ++before_next;
        } else {
            EXPECT_TRUE(logged("stopped in measurement ") || logged("stopped after 0 of "))
                << what << "\n"
                << test::log_of(r);
            ++in_one;
        }
    }
    EXPECT_GT(in_one, 0);
    EXPECT_GT(before_next, 0);
    EXPECT_GT(all, 0);
}

TEST(OutlookTest, RateIsThatOfNewestRecordingAndReserveIsNoRoom) {
    using recorded::KeptPictures;
    BenchState s;
    const auto size = [&](KeptPictures kept) {
        return outlook(s, {}, KeptPictures::first_second).sizes.at(static_cast<std::size_t>(kept));
    };
    EXPECT_EQ(size(KeptPictures::first_second).bytes_per_s, 0.8e6) << "no recording yet";
    s.recording.rate = {.bytes_per_s = 1.5e6, .pictures_per_s = 3e7, .pictures = KeptPictures::region};
    EXPECT_EQ(size(KeptPictures::off).bytes_per_s, 1.5e6);
    s.recording.rate.lasted_s = 8;
    EXPECT_EQ(size(KeptPictures::off).bytes_per_s, 0.8e6) << "a short recording is mostly fixed parts";
    s.recording.rate.lasted_s = 80;
    EXPECT_EQ(size(KeptPictures::first_second).bytes_per_s, 1.5e6) << "pictures of one second only";
    EXPECT_EQ(size(KeptPictures::region).bytes_per_s, 3.15e7);
    EXPECT_TRUE(std::isnan(size(KeptPictures::full).bytes_per_s)) << "the cameras give regions";
    s.recording.rate.pictures = KeptPictures::first_second;
    EXPECT_EQ(size(KeptPictures::region).bytes_per_s, 1.5e6) << "no picture is there yet";
    auto frame = std::make_shared<Frame>();
    frame->pixels.resize(40000);
    s.pictures_now.emplace_back().frame = frame;
    BenchFacts facts;
    facts.views.emplace_back().frame_rate_hz = 500;
    s.facts = std::make_shared<const BenchFacts>(facts);
    EXPECT_EQ(size(KeptPictures::region).bytes_per_s, 2.15e7);
    EXPECT_EQ(size(KeptPictures::first_second).first_bytes, 2e7);
    EXPECT_EQ(size(KeptPictures::off).first_bytes, 0);
    EXPECT_EQ(room_bytes(2e9), 2e9 - 1073741824);
    EXPECT_EQ(room_bytes(1e9), 0);
    EXPECT_TRUE(std::isnan(room_bytes(NAN)));
}

TEST_F(CountedRunTest, GaugesShowSetPointAndMotionAgainstLimits) {
    BenchState driven;
    const auto r = play(test::slow, {start(),
                                     {[&](const BenchState& s) {
                                          if (s.measuring) driven = s;
                                          return s.measuring;
                                      },
                                      give(End{})},
                                     until(in(RunState::idle))});
    ASSERT_EQ(driven.gauges.size(), 5U);
    for (const GaugeState& g : driven.gauges) {
        EXPECT_NEAR(g.live, g.set_point, 0.1 * g.set_point) << g.quantity;
        EXPECT_LT(g.live, g.limit) << g.quantity;
    }
    for (const GaugeState& g : r.last.gauges) EXPECT_TRUE(std::isnan(g.live)) << g.quantity << " at rest";
}

}  // namespace
}  // namespace shaker::service
