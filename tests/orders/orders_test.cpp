// The whole daemon with orders and faults on virtual time, and laws that hold at every sample. The plans are
// the same in each run: fixed seeds, and each plan in tests/orders/plans, which once broke a law.
#include <gtest/gtest.h>
#include <spdlog/fmt/fmt.h>

#include "tests/orders/alone.hpp"
#include "tests/orders/plan_text.hpp"
#include "tests/orders/simulated_disk.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/program.hpp"

namespace shaker::orders {
namespace {

const std::filesystem::path plans = test::source_dir() + "/tests/orders/plans";

/// Plays the plan; each broken law fails the test.
Outcome lawful(const Plan& plan) {
    Outcome outcome = play_alone(plan, test::fresh_folder() / "run");
    for (const Violation& v : outcome.violations) ADD_FAILURE() << text(v);
    if (!outcome.violations.empty())
        ADD_FAILURE() << text(plan) << fmt::format("its events:\n{}\n", fmt::join(outcome.log, "\n"));
    return outcome;
}

TEST(OrdersTest, EqualSeedsGiveEqualVolts) {
    const Outcome first = lawful(plan_of(7)), second = lawful(plan_of(7));
    EXPECT_EQ(first.fingerprint, second.fingerprint);
    EXPECT_GT(first.virtual_s, 9);
    EXPECT_NE(first.fingerprint, lawful(plan_of(8)).fingerprint);
}

TEST(OrdersTest, ClearHeldBackClearsNoLaterTrip) {
    EXPECT_EQ(lawful(read_plan(plans / "clear_behind_wai.plan")).trips, 1U);
}

// The second underrun meets the loop check that follows the first.
TEST(OrdersTest, UnderrunInLoopCheckComesBack) {
    constexpr auto underrun = static_cast<std::size_t>(simulated::FaultKind::underrun);
    Plan plan = read_plan(plans / "underrun_in_loop_check.plan");
    EXPECT_EQ(lawful(plan).trips, 0U);
    plan.faults.push_back({4.6, underrun, 0, 0.1});
    plan.faults.push_back({4.9, underrun, 0, 0.1});
    const Outcome fourth = lawful(plan);
    EXPECT_EQ(fourth.trips, 1U);
    EXPECT_NE(fmt::format("{}", fmt::join(fourth.log, "\n")).find("the DAC ran empty 4 times"),
              std::string::npos);
}

TEST(OrdersTest, FullDiskStopsTheDrive) {
    if (!disk_can_fail()) GTEST_SKIP() << "sanitisers do not allow replaced calls";
    EXPECT_EQ(lawful(read_plan(plans / "full_disk.plan")).trips, 1U);
}

class PlanTest : public testing::TestWithParam<std::filesystem::path> {};

TEST_P(PlanTest, LawsHold) { lawful(read_plan(GetParam())); }

INSTANTIATE_TEST_SUITE_P(Plans, PlanTest, testing::ValuesIn(plans_in(plans)),
                         [](const auto& one) { return one.param.stem().string(); });

class SeedTest : public testing::TestWithParam<std::uint64_t> {};

TEST_P(SeedTest, LawsHold) { lawful(plan_of(GetParam())); }

// Others: `tests/bench/run orders --seeds N --first SEED`.
INSTANTIATE_TEST_SUITE_P(Seeds, SeedTest,
                         testing::Range(std::uint64_t{1}, std::uint64_t{SHAKER_SANITIZED ? 9 : 41}),
                         testing::PrintToStringParamName());

}  // namespace
}  // namespace shaker::orders
