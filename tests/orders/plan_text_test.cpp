// Plans as text: nothing is lost, and wrong lines are refused.
#include "tests/orders/plan_text.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "drivers/errors.hpp"
#include "tests/support/program.hpp"

namespace shaker::orders {
namespace {

const std::string head = "plan seed=1 length_s=4 frequency_hz=10 identifies=no buffer_s=0.02 kept_s=0.01\n";

std::string refusal(const std::string& text) try {
    static_cast<void>(plan_from_text(text));
    return "accepted";
} catch (const InputError& e) {
    return e.what();
}

TEST(PlanTextTest, TextOfPlanGivesEqualPlan) {
    for (const std::uint64_t seed : {1U, 2U, 3U, 4U, 5U, 6U, 7U, 8U, 13U, 100U, 160U, 7919U}) {
        const Plan plan = plan_of(seed);
        const Plan again = plan_from_text(text(plan));
        EXPECT_EQ(again, plan) << text(plan);
        EXPECT_EQ(text(again), text(plan));
    }
}

TEST(PlanTextTest, EveryFieldIsRead) {
    const Plan plan = plan_from_text("# a law: a reason\n\n" + head +
                                     "move at_s=1 client=2 action=same_name value=0.5\n"
                                     "  # a remark\n"
                                     "fault at_s=1 what=contact_open for_s=0.2 value=0.25\n");
    Plan expected{.seed = 1, .length_s = 4, .frequency_hz = 10, .buffer_s = 0.02, .kept_s = 0.01};
    expected.moves = {{1, 2, Action::same_name, 0.5}};
    expected.faults = {{1, static_cast<std::size_t>(simulated::FaultKind::contact_open), 0.2, 0.25}};
    EXPECT_EQ(plan, expected);
}

TEST(PlanTextTest, WrongLineIsRefusedWithItsNumber) {
    EXPECT_EQ(refusal("# only a comment\n"), "the text has no line that begins with plan");
    EXPECT_EQ(refusal("move at_s=1\n"),
              "line 1: 'move': expected plan, as the first word that is not in a comment");
    EXPECT_EQ(refusal(head + head), "line 2: 'plan': expected move or fault");
    EXPECT_EQ(refusal("plan seed=-1\n"),
              "line 1: 'seed=-1': expected a number from 0 to 18446744073709551615");
    EXPECT_EQ(refusal("plan seed=1 length_s=nan\n"),
              "line 1: 'length_s=nan': expected a number from 0 to 3600");
    EXPECT_EQ(refusal("plan seed=1 length_s=4 frequency_hz=10 identifies=maybe\n"),
              "line 1: 'identifies=maybe': expected one of no, yes");
    EXPECT_EQ(refusal("plan seed=1 length_s=4 frequency_hz=10 identifies=no buffer_s=0.02 kept_s=0.03\n"),
              "line 1: 'kept_s=0.03': expected a number from 0 to 0.02");
}

TEST(PlanTextTest, WrongMoveOrFaultIsRefused) {
    EXPECT_EQ(refusal(head + "move at_s=1 client=3 action=abort value=0\n"),
              "line 2: 'client=3': expected a number from 0 to 2");
    EXPECT_EQ(refusal(head + "move at_s=1,5 client=1 action=abort value=0\n"),
              "line 2: 'at_s=1,5': expected a number from 0 to 3600");
    EXPECT_EQ(refusal(head + "move at_s=1 action=abort client=1 value=0\n"),
              "line 2: 'action=abort': expected client=a number from 0 to 2");
    EXPECT_EQ(refusal(head + "move at_s=1 client=1 action=abort\n"),
              "line 2: 'end of the line': expected value=a number from 0 to 1");
    EXPECT_EQ(refusal(head + "move at_s=1 client=1 action=abort value=0 for_s=1\n"),
              "line 2: 'for_s=1': expected the end of the line");
    EXPECT_TRUE(refusal(head + "fault at_s=1 what=fire for_s=1 value=0\n")
                    .starts_with("line 2: 'what=fire': expected one of open, frozen, "));
    // Moves are played in the order of the file.
    EXPECT_EQ(refusal(head + "fault at_s=2 what=open for_s=1 value=0\n"
                             "move at_s=1 client=1 action=abort value=0\n"),
              "line 3: 'at_s=1': expected a number from 2 to 3600");
}

TEST(PlanTextTest, WrittenFileNamesLawAndIsRead) {
    const auto folder = test::fresh_folder() / "plans";
    const Plan plan = plan_of(13);
    write_plan(folder / "seed_13.plan", plan, {"drive limit", 1.23456, "2 V\nabove the limit"});
    ASSERT_EQ(plans_in(folder).size(), 1U);
    EXPECT_EQ(read_plan(plans_in(folder).front()), plan);
    std::ifstream in{plans_in(folder).front()};
    std::string first;
    std::getline(in, first);
    EXPECT_EQ(first, "# drive limit: at 1.2346 s 2 V above the limit");
    EXPECT_THROW(static_cast<void>(read_plan(folder / "missing.plan")), InputError);
}

}  // namespace
}  // namespace shaker::orders
