// SIGKILL in a campaign: --continue finishes it, nothing is lost and nothing counts twice. More moments:
// `tests/bench/run campaigns`.
#include <gtest/gtest.h>

#include <fstream>
#include <random>

#include "tests/support/campaign/killed_campaign.hpp"
#include "tests/support/nightly.hpp"
#include "tests/support/program.hpp"

namespace shaker::test {
namespace {

constexpr const char* plan = R"([point]
periods = 10
[[series]]
gamma = ["0.7g", "1g", "1.5g"]
phi = ["0deg", "60deg"]
order = "mirror"
)";

TEST(CampaignKillTest, ContinuesAsIfItHadNotBeenKilled) {
    const std::filesystem::path folder = fresh_folder();
    std::ofstream{folder / "plan.toml"} << plan;
    const KilledCampaigns campaigns{folder / "plan.toml", folder / "runs"};
    int killed = 0, in_the_middle = 0;
    // A busy machine moves the kills to the ends: then there are more.
    for (int i = 1; i <= 4 || (in_the_middle == 0 && i <= 12); ++i) {
        const Killed one = campaigns.kill(campaigns.lasts_s() * ((i - 1) % 4 + 1) / 5, i);
        killed += one.killed ? 1 : 0;
        in_the_middle += one.ended_before > 0 && one.ended_before < 12 ? 1 : 0;
        for (const std::string& finding : one.findings) ADD_FAILURE() << finding;
    }
    EXPECT_GE(killed, 2);
    EXPECT_GE(in_the_middle, 1);
}

// A kill between any two calls that create, write, synchronise, rename or remove, and one in the
// continuation: nobody has to repair anything.
TEST(CampaignKillTest, AtEachCallItIsRecoveredAndContinued) {
    if (SHAKER_SANITIZED) GTEST_SKIP() << "sanitisers do not allow a preloaded library";
    const std::filesystem::path folder = fresh_folder();
    std::ofstream{folder / "plan.toml"}
        << "[point]\nperiods = 10\n[[series]]\ngamma = [\"0.7g\", \"1g\", \"1.5g\"]\n";
    const KilledCampaigns campaigns{folder / "plan.toml", folder / "runs", KilledCampaigns::Whole::logged};
    ASSERT_GE(campaigns.calls(), 200U);
    std::mt19937_64 draw{seed_of_day(1)};
    const auto recovered = static_cast<std::size_t>(plays(25, static_cast<int>(campaigns.calls())));
    for (std::size_t i = 0; i < recovered; ++i) {
        const std::size_t call = (i * campaigns.calls() + draw() % campaigns.calls()) / recovered;
        for (const std::string& finding : campaigns.recover_at(call))
            ADD_FAILURE() << call << ": " << finding;
    }
    int killed_again = 0;
    for (int i = 0; i < plays(5, 50); ++i) {
        const std::size_t call = 1 + draw() % campaigns.calls(),
                          again = draw() % 2 == 0 ? 1 + draw() % 30 : 1 + draw() % campaigns.calls();
        const Killed one = campaigns.kill_at(call, again);
        killed_again += one.killed_again ? 1 : 0;
        for (const std::string& finding : one.findings)
            ADD_FAILURE() << "call " << call << ", then " << again << ": " << finding;
    }
    EXPECT_GE(killed_again, 1);
    std::printf("%zu calls, %zu recovered, %d killed again\n", campaigns.calls(), recovered, killed_again);
}

}  // namespace
}  // namespace shaker::test
