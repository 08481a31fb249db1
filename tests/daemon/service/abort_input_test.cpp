// The contact of the abort input opens while the bench on call drives.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/program.hpp"
#include "tests/support/run/bench_on_call.hpp"

namespace shaker::service {
namespace {

using run::RunState;
using test::Answers;
using test::in;
using test::orders;

TEST(AbortInputTest, ClearIsRefusedWhileTheContactIsOpen) {
    std::string scene = test::slow;
    scene += "[[fault]]\nwhat = \"contact_open\"\nat_s = 4\nfor_s = 2\n";
    Answers answers;
    const auto silent_at = [](double s) {
        return [s](const BenchState& state) { return state.may_clear && state.now_s > s; };
    };
    std::vector<std::optional<Contact>> shown;
    const auto noted = [&](const std::function<bool(const BenchState&)>& when) {
        return [&shown, when](const BenchState& state) {
            const bool now = when(state);
            if (now) shown.push_back(state.contact);
            return now;
        };
    };
    const auto r = test::play_on_call(scene, test::quick(), test::fresh_folder(),
                                      {{noted(in(RunState::idle)), orders(Begin{10}, answers)},
                                       {noted(silent_at(4)), orders(ClearTrip{}, answers)},
                                       {noted(silent_at(6.5)), orders(ClearTrip{}, answers)},
                                       {in(RunState::idle), [](BenchPort&) {}}});
    ASSERT_EQ(answers.size(), 3U);
    EXPECT_EQ(shown, (std::vector<std::optional<Contact>>{Contact::closed, Contact::open, Contact::closed}));
    EXPECT_NE(answers[1].find("the contact of the abort input is open"), std::string::npos) << answers[1];
    EXPECT_EQ(answers[2], "");
    EXPECT_EQ(r.last.trips, 1U) << log_of(r);
    EXPECT_TRUE(std::ranges::any_of(r.events, [](const BenchEvent& e) {
        return e.text.find("abort_input") != std::string::npos;
    })) << log_of(r);
}

}  // namespace
}  // namespace shaker::service
