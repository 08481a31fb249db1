#include "daemon/campaign/plan_check.hpp"

#include <gtest/gtest.h>
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "daemon/campaign/plan.hpp"
#include "drivers/errors.hpp"
#include "tests/support/paths.hpp"

namespace shaker::campaign {
namespace {

// 640 px of the paper's bench.
const CheckSettings wide{.way = {.view = 0.256, .walker = 0.03}, .start = -0.05};

PlanCheck checked(const Plan& plan, const CheckSettings& settings) {
    return check_plan(plan, schedule(plan), settings);
}

PlanCheck paper(const CheckSettings& settings) {
    return checked(read_plan(test::source_dir() + "/daemon/campaign/plans/paper.toml"), settings);
}

TEST(PlanCheckTest, PaperFitsIn18MinutesOfBench) {
    const PlanCheck check = paper(wide);
    EXPECT_EQ(check.points.size(), 228U);
    EXPECT_EQ(check.failing, 0U);
    EXPECT_LT(check.bench_s(), 18 * 60);
    EXPECT_GT(check.bench_s(), 10 * 60);
    EXPECT_NEAR(check.measuring_s, 228 * 2.0, 10);
}

TEST(PlanCheckTest, NarrowViewFailsFastPointsByName) {
    const PlanCheck check = paper({.way = {.view = 0.128, .walker = 0.03}});
    EXPECT_GT(check.failing, 0U);
    const auto fails = std::ranges::find_if(check.points, [](const auto& c) { return !c.travel.fits(); });
    EXPECT_GT(fails->point.asked.drive.gamma, 2 * paper_g);
    EXPECT_NE(check_text(check).find(
                  fmt::format("point {} does not fit: settling and 5 periods need", fails->point.id)),
              std::string::npos)
        << check_text(check);
}

TEST(PlanCheckTest, TextHasARowForEachPointAndTheSums) {
    const PlanCheck check = checked(
        parse_plan("title = \"Two\"\n[[series]]\nname = \"a\"\nphi = [0, \"90deg\"]\n", "p.toml"), wide);
    EXPECT_EQ(check_text(check), R"(Two
predicted with mu 0.113; free way 212.0 mm

point  series       gamma     phi   rho frequ     v_D     way passes    from      to
                        g     deg            Hz    mm/s      mm             mm      mm
    1  a                 1    0.00   0.5     20   14.58    48.9      1   -50.0    -1.1
    2  a                 1   90.00   0.5     20    9.16    30.7      1    -1.1    29.5

2 points, 2 fit
bench time 15.3 s: measuring 4.0 s, settling 2.6 s, returning 0.0 s, start 8.0 s, other 0.7 s
recording about 5 MB
)");
}

TEST(PlanCheckTest, JsonRowsAddUpToTheSums) {
    const PlanCheck check = paper(wide);
    const auto json = nlohmann::json::parse(check_json(check));
    double sum = json.at("start_s");
    for (const auto& row : json.at("points")) sum += row.at("bench_s").get<double>();
    EXPECT_NEAR(sum, json.at("bench_s"), 1e-6);
    EXPECT_EQ(json.at("points").size(), 228U);
    EXPECT_EQ(json.at("points").at(0).at("partner"), 2);
    EXPECT_EQ(json.at("points").at(0).at("frequency_hz"), 20);
}

TEST(PlanCheckTest, LimitsRefuseWithLineAndNearestGamma) {
    const Plan plan =
        parse_plan("[[series]]\nname = \"a\"\nphi = [0, 1]\ngamma = [\"1g\", \"3g\"]\n", "p.toml");
    const auto demands = [](const Drive& drive) {
        return std::vector<safety::Demand>{{"acceleration", 2 * drive.gamma, 4.5678 * paper_g, "m/s^2"}};
    };
    try {
        require_within_limits(plan, schedule(plan), demands);
        FAIL() << "accepted";
    } catch (const InputError& error) {
        EXPECT_STREQ(
            error.what(),
            "p.toml:4: series \"a\", gamma 3g: the drive exceeds the limits: acceleration peak 58.8 m/s^2 "
            "(limit 44.76 m/s^2); at most gamma 22.38 m/s^2 (2.28 g) is allowed for this shape");
    }
}

}  // namespace
}  // namespace shaker::campaign
