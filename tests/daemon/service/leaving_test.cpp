// Orders to a program that was ordered to end.
#include <gtest/gtest.h>

#include "tests/support/run/bench_on_call.hpp"

namespace shaker::service {
namespace {

using run::RunState;
using test::entered;
using test::in;
using test::slow;
using test::until;

class LeavingTest : public test::OnCallBench {
protected:
    /// Each order that starts, changes or clears a drive.
    void drive(BenchPort& port) {
        Drive other;
        other.gamma = 5;
        give(SetDrive{other})(port);
        give(Begin{10})(port);
        give(Identify{})(port);
        give(ClearTrip{})(port);
    }
    [[nodiscard]] std::function<void(BenchPort&)> drives() {
        return [this](BenchPort& port) { drive(port); };
    }
    void expect_refused(std::size_t from, std::size_t to) const {
        ASSERT_EQ(answers.size(), to) << testing::PrintToString(answers);
        for (std::size_t i = from; i < to; ++i)
            EXPECT_EQ(answers[i], "the program is ending; give the order after its next start") << i;
    }
};

TEST_F(LeavingTest, NothingStartsChangesOrIsCleared) {
    const auto r = play(
        slow,
        {start(), {in(RunState::run), drives(), true}, {in(RunState::ramp_down), [this](BenchPort& port) {
                                                            drive(port);
                                                            give(Remark{"the lamp flickers"})(port);
                                                        }}});
    ASSERT_EQ(answers.size(), 10U);
    EXPECT_EQ(answers.back(), "");
    answers.pop_back();
    expect_refused(1, 9);
    EXPECT_EQ(r.last.wanted.gamma, paper_g);
    EXPECT_EQ(r.last.state, RunState::idle);
    EXPECT_EQ(entered(r, RunState::ramp_down).size(), 1U);
    EXPECT_EQ(entered(r, RunState::loop_check).size() + entered(r, RunState::ramp).size(), 1U) << log_of(r);
}

TEST_F(LeavingTest, ProgramAtRestEndsInSpiteOfStarts) {
    const auto r = play(slow, {{in(RunState::idle), drives(), true}});
    expect_refused(0, 4);
    EXPECT_TRUE(entered(r, RunState::identify).empty()) << log_of(r);
}

TEST_F(LeavingTest, TripStaysUncleared) {
    const auto r = play(slow, {{in(RunState::idle), [](BenchPort& port) { port.abort("a test"); }},
                               until(in(RunState::tripped)),
                               {test::may_clear, drives(), true}});
    expect_refused(0, 4);
    EXPECT_EQ(r.last.state, RunState::tripped);
}

}  // namespace
}  // namespace shaker::service
