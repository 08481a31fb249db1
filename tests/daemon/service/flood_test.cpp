// More orders than a step obeys.
#include <gtest/gtest.h>

#include <set>

#include "tests/support/run/bench_on_call.hpp"

namespace shaker::service {
namespace {

using run::RunState;
using test::in;
using test::slow;
using test::until;

class FloodTest : public test::OnCallBench {
protected:
    static constexpr int at_once = 100;
    /// Each answer gives the next order, as a client does that sends without end.
    void flood(BenchPort& port) {
        if (++given_ < most_given)
            port.order({Remark{"flood"}, [this, &port](const std::string&) { flood(port); }});
    }
    static constexpr int most_given = 50000;
    int given_ = 0;
};

TEST_F(FloodTest, StepObeysFewOrdersAndPublishesOnce) {
    std::vector<std::shared_ptr<const BenchState>> states;
    std::vector<std::uint64_t> answered;
    const auto many = [&](BenchPort& port) {
        for (int i = 0; i < at_once; ++i)
            port.order({Remark{"flood"}, [&](const std::string& refused) {
                            EXPECT_EQ(refused, "");
                            states.push_back(port.state());
                        }});
    };
    play(slow, {{in(RunState::idle), many}, until(in(RunState::idle))});
    ASSERT_EQ(states.size(), static_cast<std::size_t>(at_once));
    const std::set<std::shared_ptr<const BenchState>> different(states.begin(), states.end());
    EXPECT_EQ(different.size(), 7U) << "16 orders each, and 4";
    for (std::size_t i = 0; i < states.size(); ++i)
        EXPECT_GE(states[i]->answered, i + 1) << "an answer comes after the state that shows it";
}

TEST_F(FloodTest, AbortIsNotBehindOrders) {
    int before = 0, answered = 0;
    const auto many = [&](BenchPort& port) {
        for (std::size_t i = 0; i < BenchPort::most_orders - 1; ++i)
            port.order({Remark{"flood"}, [&](const std::string&) {
                            ++answered;
                            if (port.obeyed() < port.aborted()) ++before;
                        }});
        port.abort("a test");
    };
    const auto r = play(slow, {start(), {in(RunState::run), many}, until(in(RunState::tripped))});
    EXPECT_EQ(answered, static_cast<int>(BenchPort::most_orders) - 1);
    EXPECT_LT(before, 64) << "orders that were answered before the output obeyed";
    EXPECT_EQ(r.last.trip->cause, safety::Cause::operator_stop);
}

TEST_F(FloodTest, ProgramEndsDuringAFlood) {
    const auto r = play(slow,
                        {start(),
                         {in(RunState::run),
                          [&](BenchPort& port) {
                              for (int i = 0; i < at_once; ++i) flood(port);
                          },
                          true}},
                        20);
    EXPECT_LT(given_, most_given) << "the control was kept from its steps";
    EXPECT_EQ(r.last.state, RunState::idle);
    EXPECT_LT(r.virtual_s, 15);
}

}  // namespace
}  // namespace shaker::service
