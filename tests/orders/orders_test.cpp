// The whole daemon with random orders, faults of devices, disk and computer, and laws that hold at every
// sample.
#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>

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

// Seeds that changes with SHAKER_SEED; `tests/bench/run orders` plays more.
TEST(OrdersTest, LawsHoldForSeedsOfTheDay) {
    const auto folder = test::fresh_folder();
    const char* day = std::getenv("SHAKER_SEED");
    const std::uint64_t first = 1000 * (day == nullptr ? 1 : std::strtoull(day, nullptr, 10)) + 1;
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds{SHAKER_SANITIZED ? 20 : 60};
    for (std::uint64_t seed = first; std::chrono::steady_clock::now() < end; ++seed) {
        const Plan plan = plan_of(seed);
        const Outcome outcome = simulate(plan, folder / "run");
        std::filesystem::remove_all(folder / "run");
        ASSERT_TRUE(outcome.violations.empty()) << words(plan, outcome);
    }
}

}  // namespace
}  // namespace shaker::orders
