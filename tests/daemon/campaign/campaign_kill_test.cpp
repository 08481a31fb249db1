// SIGKILL in a campaign: --continue finishes it, nothing is lost and nothing counts twice. More moments:
// `tests/bench/run campaigns`.
#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/campaign/killed_campaign.hpp"
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
    for (int i = 1; i <= 4; ++i) {
        const Killed one = campaigns.kill(campaigns.lasts_s() * i / 5, i);
        killed += one.killed ? 1 : 0;
        in_the_middle += one.ended_before > 0 && one.ended_before < 12 ? 1 : 0;
        for (const std::string& finding : one.findings) ADD_FAILURE() << finding;
    }
    EXPECT_GE(killed, 2);
    EXPECT_GE(in_the_middle, 1);
}

}  // namespace
}  // namespace shaker::test
