// A campaign in real time on the mock bench: real libasound, libiio and Aravis on both sides.
#include <gtest/gtest.h>
#include <spdlog/fmt/fmt.h>

#include <cmath>
#include <fstream>

#include "daemon/campaign/campaign_folder.hpp"
#include "daemon/campaign/points_table.hpp"
#include "tests/support/in_real_time.hpp"
#include "tests/support/run/bench_run.hpp"

namespace shaker::test {
namespace {

constexpr const char* plan = R"([point]
periods = 20
[[series]]
gamma = "1g"
phi = ["0deg", "45deg", "90deg"]
order = "mirror"
)";
constexpr double longest_s = 180;

TEST(MockCampaignTest, SixPointsAreMeasuredInRealTime) {
    BenchRun run;
    std::ofstream{run.folder / "plan.toml"} << plan;
    Program program{"shakerd",
                    fmt::format("campaign plan.toml --rig '{}' -o points", run.bench.rig_file().string()),
                    run.folder};
    const Outcome outcome = program.wait(longest_s);
    if (!in_real_time) return expect_order(outcome);
    ASSERT_EQ(outcome.status, 0) << end_of(outcome.out) << end_of(outcome.err);
    const auto table = campaign::read_points(run.folder / "points" / campaign::table_name);
    ASSERT_EQ(table.points.size(), 6U);
    for (const campaign::PointRow& row : table.points) {
        EXPECT_EQ(row.outcome, "measured") << row.point << ": " << row.reason;
        if (row.partner == 0) continue;
        const campaign::PointRow& partner = table.points.at(static_cast<std::size_t>(row.partner - 1));
        EXPECT_NEAR(row.v_D.value, -partner.v_D.value, 0.3e-3) << "a level base";
    }
    EXPECT_EQ(shakerd("campaign points --reduce", run.folder).status, 0);
}

}  // namespace
}  // namespace shaker::test
