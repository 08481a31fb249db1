#include "daemon/safety/edge_permit.hpp"

#include <gtest/gtest.h>

namespace shaker::safety {
namespace {

// A walker that was 3 mm from the edge at its trip.
EdgePermit at_three() { return {3, 5, EdgePermit::outer_limit_mm(3)}; }

std::optional<Trip> judged(EdgePermit& permit, double mm, double periods) {
    return permit.judge(EdgePermit::Place{mm, mm}, 0, periods);
}

TEST(EdgePermitTest, EndsWhenTheWalkerIsInside) {
    EdgePermit permit = at_three();
    for (double mm = 3; mm < 5; mm += 0.1) {
        EXPECT_FALSE(judged(permit, mm, 10 * (mm - 3)));
        EXPECT_FALSE(permit.over());
    }
    EXPECT_FALSE(judged(permit, 5.01, 21));
    EXPECT_TRUE(permit.over());
}

TEST(EdgePermitTest, HalfAMillimetreOutwardsTrips) {
    EdgePermit permit = at_three();
    EXPECT_FALSE(judged(permit, 2.51, 1));
    const auto trip = judged(permit, 2.49, 2);
    ASSERT_TRUE(trip);
    EXPECT_EQ(trip->cause, Cause::walker_edge);
    EXPECT_EQ(trip->limit, 2.5);
}

TEST(EdgePermitTest, OuterLimitHoldsForEveryFrame) {
    EdgePermit permit = at_three();
    EXPECT_FALSE(permit.judge(EdgePermit::Place{1.01, 3}, 0, 1)) << "it oscillates with the base";
    const auto trip = permit.judge(EdgePermit::Place{0.99, 3}, 0, 1);
    ASSERT_TRUE(trip);
    EXPECT_EQ(trip->limit, 1);
    EXPECT_EQ(EdgePermit::outer_limit_mm(1.5), 0) << "the end of the picture";
}

TEST(EdgePermitTest, WalkerThatIsNotSeenTrips) {
    EdgePermit permit = at_three();
    EXPECT_FALSE(permit.judge(EdgePermit::Place{3, 3}, 2, 1));
    const auto trip = permit.judge(EdgePermit::Place{3, 3}, 3, 1);
    ASSERT_TRUE(trip);
    EXPECT_EQ(trip->cause, Cause::tracking_lost);
    EdgePermit unknown = at_three();
    EXPECT_TRUE(unknown.judge(std::nullopt, 0, 1));
}

TEST(EdgePermitTest, StandingStillForTwentyPeriodsTrips) {
    EdgePermit permit = at_three();
    EXPECT_FALSE(judged(permit, 3.05, 20));
    EXPECT_TRUE(judged(permit, 3.05, 20.1));
    EdgePermit slow = at_three();
    for (int n = 1; n <= 15; ++n) EXPECT_FALSE(judged(slow, 3 + 0.11 * n, 19.0 * n)) << n;
    EXPECT_TRUE(judged(slow, 3 + 0.11 * 15, 19.0 * 15 + 21)) << "it has stopped on the way";
}

TEST(EdgePermitTest, RestartOfTheDriveGivesNoMoreTime) {
    EdgePermit permit = at_three();
    EXPECT_FALSE(judged(permit, 3.2, 15));
    EXPECT_FALSE(judged(permit, 3.2, 0)) << "ramp after an underrun";
    EXPECT_FALSE(judged(permit, 3.2, 20));
    EXPECT_TRUE(judged(permit, 3.2, 20.1));
}

TEST(EdgePermitTest, WalkerThatTurnsTrips) {
    EdgePermit permit = at_three();
    for (double mm = 3; mm < 4.5; mm += 0.1) EXPECT_FALSE(judged(permit, mm, 10 * (mm - 3)));
    EXPECT_FALSE(judged(permit, 4.1, 15));
    const auto trip = judged(permit, 3.9, 16);
    ASSERT_TRUE(trip);
    EXPECT_NEAR(trip->limit, 4, 0.11) << "half a millimetre from its innermost place";
}

}  // namespace
}  // namespace shaker::safety
