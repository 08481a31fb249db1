// A return: when the next drive is ordered, and what is learned from where the walker turned.
#include "daemon/on_call/way_back.hpp"

#include <gtest/gtest.h>

namespace shaker::on_call {
namespace {

constexpr double step_m = 1e-3, period_s = 0.05;

/// Leads a walker that goes on for `goes_on` periods after the order; returns how far beyond the target it
/// turned, m.
double error_of(WayBack& back, double goes_on, double length_m = 0.1) {
    double way = 0.02;
    back.begin(0, 0, 1, way, 0.06, step_m, period_s);
    double now_s = 0;
    for (; !back.arrives({length_m - way, way}); now_s += period_s / 10) way += step_m / 10;
    back.leave(now_s, way);
    for (int i = 0; i < 10 * goes_on; ++i) back.follow(way += step_m / 10);
    for (int i = 0; i < 10; ++i) back.follow(way -= step_m);  // the next pass
    const WayBack::Done done = back.end();
    EXPECT_NEAR(done.x_from_m, 0, 1e-12);
    EXPECT_NEAR(done.x_asked_m, -0.04, 1e-12);
    EXPECT_GT(done.for_s, 0);
    return done.x_asked_m - done.x_to_m;
}

TEST(WayBackTest, LearnsHowFarTheWalkerGoesOn) {
    WayBack back;
    EXPECT_GT(error_of(back, 6), 2e-3);
    for (int i = 0; i < 6; ++i) error_of(back, 6);
    EXPECT_LT(std::abs(error_of(back, 6)), 0.2e-3);
}

TEST(WayBackTest, EndsBeforeTheOtherEdge) {
    WayBack back;
    EXPECT_LT(error_of(back, 3, 0.05), -5e-3) << "short of its target";
    EXPECT_NEAR(error_of(back, 3), 0, 0.2e-3) << "still three periods";
}

TEST(WayBackTest, IsLateWhenTheWalkerDoesNotCome) {
    WayBack back;
    back.begin(10, 0, 0, 0.02, 0.06, step_m, period_s);
    EXPECT_FALSE(back.late(12));  // 40 periods are 2 s
    EXPECT_TRUE(back.late(10 + 3 * 2 + 15.1));
}

}  // namespace
}  // namespace shaker::on_call
