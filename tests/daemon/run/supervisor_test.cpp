// Stops that the supervisor orders: one until the output has answered it, another after one that was excused.
#include "daemon/run/supervisor.hpp"

#include <gtest/gtest.h>

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
