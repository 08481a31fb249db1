// The whole daemon with random orders, faults of devices, disk and computer, and laws that hold at every
// sample.
#include <gtest/gtest.h>
#include <spdlog/fmt/fmt.h>

#include <cstdlib>

#include "tests/orders/campaign.hpp"
#include "tests/orders/kept_data.hpp"
#include "tests/orders/simulated_disk.hpp"
#include "tests/orders/simulation.hpp"
#include "tests/support/program.hpp"

namespace shaker::orders {
namespace {

std::string words(const Plan& plan, const Outcome& outcome) {
    std::string all;
    for (const Violation& v : outcome.violations)
        all += fmt::format("{}: at {:.4f} s {}\n", v.law, v.at_s, v.words);
    return all + text(plan);
}

TEST(OrdersTest, EqualSeedsGiveEqualVolts) {
    const auto folder = test::fresh_folder();
    const Plan plan = plan_of(7);
    const Outcome first = simulate(plan, folder / "first"), second = simulate(plan, folder / "second");
    EXPECT_EQ(first.fingerprint, second.fingerprint);
    EXPECT_GT(first.virtual_s, 9);
    EXPECT_NE(first.fingerprint, simulate(plan_of(8), folder / "other").fingerprint);
}

// The client's *WAI holds its clear back until the trip; the drive must not come back.
TEST(OrdersTest, ClearHeldBackClearsNoLaterTrip) {
    constexpr double wai = 0.85;
    Plan plan{.seed = 1, .length_s = 4, .frequency_hz = 10};
    plan.moves = {{1.0, 2, Action::start, 0.5},
                  {1.3, 0, Action::nonsense, wai},
                  {1.6, 0, Action::clear, 0},
                  {3.0, 2, Action::start, 0.5}};
    plan.faults = {{1.95, static_cast<std::size_t>(simulated::FaultKind::saturated), 0.2, 0}};
    const Outcome outcome = simulate(plan, test::fresh_folder() / "run");
    EXPECT_EQ(outcome.trips, 1U);
    EXPECT_TRUE(outcome.violations.empty()) << words(plan, outcome);
}

// The second underrun meets the loop check that follows the first.
TEST(OrdersTest, UnderrunInLoopCheckComesBack) {
    constexpr auto underrun = static_cast<std::size_t>(simulated::FaultKind::underrun);
    Plan plan{.seed = 1, .length_s = 9};
    plan.moves = {{1.0, 0, Action::start, 0.5}};
    plan.faults = {{4.0, underrun, 0, 0.1}, {4.3, underrun, 0, 0.1}};
    const Outcome twice = simulate(plan, test::fresh_folder() / "twice");
    EXPECT_EQ(twice.trips, 0U);
    EXPECT_TRUE(twice.violations.empty()) << words(plan, twice);
    plan.faults.push_back({4.6, underrun, 0, 0.1});
    plan.faults.push_back({4.9, underrun, 0, 0.1});
    const Outcome fourth = simulate(plan, test::fresh_folder() / "fourth");
    EXPECT_EQ(fourth.trips, 1U);
    EXPECT_TRUE(fourth.violations.empty()) << words(plan, fourth);
    EXPECT_NE(fmt::format("{}", fmt::join(fourth.log, "\n")).find("the DAC ran empty 4 times"),
              std::string::npos);
}

TEST(OrdersTest, FullDiskLeavesNoFileOpen) {
    if (!disk_can_fail()) GTEST_SKIP() << "sanitisers do not allow replaced calls";
    Plan plan{.seed = 1, .length_s = 5, .frequency_hz = 50};
    plan.moves = {{0.8, 2, Action::record, 0.5}, {1.0, 0, Action::start, 0.3}};
    plan.faults = {{2.0, static_cast<std::size_t>(Trouble::disk_full), 0.3, 0}};
    const std::size_t before = left_open();
    const Outcome outcome = simulate(plan, test::fresh_folder() / "run");
    EXPECT_EQ(outcome.trips, 1U);
    EXPECT_EQ(left_open(), before);
    EXPECT_TRUE(outcome.violations.empty()) << words(plan, outcome);
}

// The recording ends while its disk fails: HDF5 still has to write when it closes the file.
TEST(OrdersTest, DiskThatFailsAtTheEndLeavesNoFileOpen) {
    if (!disk_can_fail()) GTEST_SKIP() << "sanitisers do not allow replaced calls";
    Plan plan{.seed = 1, .length_s = 5, .frequency_hz = 50, .identifies = true};
    plan.moves = {{0.8, 2, Action::record, 0.5}, {1.0, 0, Action::start, 0.3}, {2.56, 0, Action::abort, 0}};
    plan.faults = {{2.5, static_cast<std::size_t>(Trouble::disk_error), 0.6, 0}};
    const std::size_t before = left_open();
    const Outcome outcome = simulate(plan, test::fresh_folder() / "run");
    EXPECT_EQ(left_open(), before);
    EXPECT_TRUE(outcome.violations.empty()) << words(plan, outcome);
}

// The seeds change with SHAKER_SEED; `tests/bench/run orders` plays more.
TEST(OrdersTest, LawsHoldForSeedsOfTheDay) {
    const char* day = std::getenv("SHAKER_SEED");
    const std::uint64_t first = 1000 * (day == nullptr ? 1 : std::strtoull(day, nullptr, 10)) + 1;
    const Totals totals = play({.first = first,
                                .most_s = SHAKER_SANITIZED ? 20.0 : 60.0,
                                .jobs = 1,
                                .folder = test::fresh_folder()});
    EXPECT_GE(totals.seeds, 2U);
    for (const auto& [seed, why] : totals.broken)
        ADD_FAILURE() << "seed " << seed << ": " << why << "\n" << text(plan_of(seed));
}

}  // namespace
}  // namespace shaker::orders
