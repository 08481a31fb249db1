// Stops that the supervisor orders: one until the output has answered it, another after one that was excused.
#include "daemon/run/supervisor.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace shaker::run {
namespace {

using safety::Cause;

struct SupervisorTest : testing::Test {
    Supervisor supervisor{safety::Limits{}, AccelerometerInfo{.name = "none", .rate_hz = 4000}, 48000, 9.8};
    acquisition::Channels channels{0};

    void find() { supervisor.stop({.cause = Cause::walker_edge, .value = 4, .limit = 5}, 1, channels); }
    int ordered() {
        int n = 0;
        while (channels.ordered.pop()) ++n;
        return n;
    }
};

/// A window at rest of a sensor without gravity, whose constant part decays.
bool rests(Supervisor& supervisor, acquisition::Channels& channels, double at_s, double mean) {
    control::PeriodWindows::Window window;
    window.from_s = at_s - 0.05;
    window.to_s = at_s;
    window.estimate.mean = {mean, 0, 0};
    window.estimate.samples = 200;
    window.estimate.residual = 0.01;
    return supervisor.check_at_rest(window, channels);
}

TEST(SettlingTest, ASensorWithoutGravityIsAwaited) {
    Supervisor supervisor{safety::Limits{},
                          AccelerometerInfo{.name = "analog", .rate_hz = 4000, .axes = 1, .gravity = false},
                          48000, 9.8};
    acquisition::Channels channels{0};
    const auto mean = [](double t) { return 30 * std::exp(-t / 1.6); };
    double settled_s = 0;
    for (double t = 0.05; settled_s == 0 && t < 30; t += 0.05)
        if (rests(supervisor, channels, t, mean(t))) settled_s = t;
    const double change = mean(settled_s - 0.5) - mean(settled_s);  // in half a second
    EXPECT_LT(change, 0.06);
    EXPECT_GT(settled_s, 5);
    EXPECT_LT(settled_s, 12);
    EXPECT_FALSE(supervisor.settles());
    supervisor.rearm();
    EXPECT_FALSE(rests(supervisor, channels, 40, 0.3)) << "one window shows no change";
    EXPECT_TRUE(rests(supervisor, channels, 40.6, 0.3));
    EXPECT_FALSE(channels.ordered.pop()) << "nothing is stopped";
}

TEST(SettlingTest, OneThatNeverRestsIsTakenAfterAMinute) {
    Supervisor supervisor{safety::Limits{},
                          AccelerometerInfo{.name = "analog", .rate_hz = 4000, .axes = 1, .gravity = false},
                          48000, 9.8};
    acquisition::Channels channels{0};
    for (double t = 0.05; t < 60; t += 0.5) {
        EXPECT_FALSE(rests(supervisor, channels, t, t)) << t;
        EXPECT_EQ(supervisor.settles(), t > 0.5) << t;
    }
    EXPECT_TRUE(rests(supervisor, channels, 60.1, 60.1));
}

TEST_F(SupervisorTest, OrdersOneStopUntilItIsRearmed) {
    find();
    find();
    EXPECT_EQ(ordered(), 1);
    find();
    EXPECT_EQ(ordered(), 0);
    supervisor.rearm();
    find();
    EXPECT_EQ(ordered(), 1);
}

TEST_F(SupervisorTest, OrdersAgainAfterExcusedStop) {
    find();
    ++channels.excused;
    find();
    find();
    EXPECT_EQ(ordered(), 2);
}

TEST_F(SupervisorTest, OrdersAgainAfterFullRing) {
    while (channels.ordered.push({})) {
    }
    find();
    EXPECT_EQ(channels.lost.trips_lost, 1U);
    ordered();
    find();
    EXPECT_EQ(ordered(), 1);
}

}  // namespace
}  // namespace shaker::run
