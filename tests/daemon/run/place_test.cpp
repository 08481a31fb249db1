// The local gravity is a setting, with which the check of the resting sensor compares.
#include <gtest/gtest.h>

#include "tests/support/run/virtual_run.hpp"

namespace shaker::run {
namespace {

TEST(PlaceTest, LocalGravityDoesNotTrip) {
    const test::VirtualRun r = test::run_virtually({.scene = "gravity_mps2 = 4\n"});
    EXPECT_FALSE(r.trip) << text(*r.trip);
    EXPECT_TRUE(r.entered_s.contains(RunState::run));
}

TEST(PlaceTest, WrongGravityTripsAtRest) {
    const test::VirtualRun r =
        test::run_virtually({.scene = "[[fault]]\nwhat = \"gain\"\nvalue = 0.4\nat_s = 0\n"});
    ASSERT_TRUE(r.trip);
    EXPECT_EQ(r.trip->cause, safety::Cause::gravity);
    EXPECT_NEAR(r.trip->value, 0.4, 0.01) << "of the 9.8 m/s^2 that the place has by default";
    EXPECT_FALSE(r.entered_s.contains(RunState::run));
}

}  // namespace
}  // namespace shaker::run
