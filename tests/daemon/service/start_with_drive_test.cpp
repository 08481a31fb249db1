// An order that starts a run at a new set-point: both are done, or neither.
#include <gtest/gtest.h>

#include "daemon/service/pending_orders.hpp"
#include "tests/support/run/bench_on_call.hpp"

namespace shaker::service {
namespace {

using run::RunState;
using test::Answers;
using test::in;
using test::until;

class StartWithDriveTest : public test::OnCallBench {
protected:
    static Begin at(double gamma) {
        Drive drive;
        drive.gamma = gamma;
        drive.phi = 1.75;
        return {{.periods = 10, .measurements = 1}, drive};
    }
};

TEST_F(StartWithDriveTest, RunIsDrivenAtNewSetPoint) {
    const auto r = play(
        test::slow, {{in(RunState::idle), give(at(7))}, until(in(RunState::run)), until(in(RunState::idle))});
    EXPECT_EQ(answers, Answers(1, ""));
    ASSERT_EQ(r.last.points.size(), 1U) << test::log_of(r);
    EXPECT_NEAR(r.last.points[0].gamma.value, 7, 0.01);
    EXPECT_EQ(r.last.points[0].asked.phi, 1.75);
    EXPECT_EQ(r.last.wanted.gamma, 7);
}

TEST_F(StartWithDriveTest, RefusedRunLeavesSetPoint) {
    Begin short_run = at(7);
    short_run.plan.periods = 1;
    const auto r = play(test::slow, {{in(RunState::idle), give(at(900))},
                                     {in(RunState::idle), give(short_run)},
                                     until(in(RunState::idle))});
    ASSERT_EQ(answers.size(), 2U);
    EXPECT_NE(answers[0].find("gamma"), std::string::npos) << answers[0];
    EXPECT_NE(answers[1].find("periods 1"), std::string::npos) << answers[1];
    EXPECT_EQ(r.last.wanted, options.drive);
    EXPECT_TRUE(test::entered(r, RunState::ramp).empty());
}

TEST_F(StartWithDriveTest, RefusedDuringARunLeavesSetPoint) {
    const auto r = play(
        test::slow,
        {{in(RunState::idle), give(at(7))}, {in(RunState::run), give(at(5))}, until(in(RunState::idle))});
    ASSERT_EQ(answers.size(), 2U);
    EXPECT_NE(answers[1], "");
    EXPECT_EQ(r.last.wanted.gamma, 7);
}

TEST(PendingOrdersTest, StartAtNewSetPointIsLoggedWithIt) {
    Drive drive;
    drive.gamma = 0.5 * paper_g;
    EXPECT_EQ(words_of(Begin{{.periods = 20, .measurements = 3}, drive}).text,
              "start (3 x 20 periods) at the new set-point 20 Hz, gamma 0.5 g, rho 0.5, phi 0 deg");
    EXPECT_EQ(words_of(Begin{{.periods = 20, .measurements = 3}}).text, "start (3 x 20 periods)");
}

}  // namespace
}  // namespace shaker::service
