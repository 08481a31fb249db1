#include <gtest/gtest.h>
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "daemon/campaign/plan.hpp"
#include "drivers/errors.hpp"

namespace shaker::campaign {
namespace {

constexpr const char* grid = R"([[series]]
frequency = [10, 20]
gamma = [1, 2, 3]
phi = [0, 0.5]
)";

std::vector<Point> points(const std::string& text) { return schedule(parse_plan(text, "p.toml")); }

std::vector<double> gammas(const std::vector<Point>& points) {
    std::vector<double> list;
    for (const Point& p : points) list.push_back(p.asked.drive.gamma);
    return list;
}

TEST(ScheduleTest, PhiIsNestedInGammaInFrequency) {
    const std::vector<Point> all = points(grid);
    ASSERT_EQ(all.size(), 12U);
    for (int i = 0; i < 12; ++i) {
        const Point& p = all.at(static_cast<std::size_t>(i));
        EXPECT_EQ(p.id, i + 1);
        EXPECT_EQ(p.asked.drive.phi, i % 2 * 0.5);
        EXPECT_EQ(p.asked.drive.gamma, 1 + i / 2 % 3);
        EXPECT_EQ(p.asked.drive.frequency, i < 6 ? 10 : 20);
        EXPECT_EQ(p.partner, 0);
    }
}

TEST(ScheduleTest, MirrorPartnersFollowEachOther) {
    const std::vector<Point> all = points(fmt::format("{}order = \"mirror\"\nrepeats = 2\n", grid));
    ASSERT_EQ(all.size(), 48U);
    for (std::size_t i = 0; i < all.size(); i += 2) {
        const Point &first = all[i], &second = all[i + 1];
        EXPECT_EQ(first.partner, second.id);
        EXPECT_EQ(second.partner, first.id);
        EXPECT_EQ(first.repeat, i < 24 ? 1 : 2);
        EXPECT_EQ(second.repeat, first.repeat);
        EXPECT_EQ(first.asked.drive.gamma, second.asked.drive.gamma);
        EXPECT_NEAR(second.asked.drive.phi - first.asked.drive.phi, std::numbers::pi, 1e-15);
    }
}

// Half a period later the acceleration of the partner is the opposite, at every phase.
TEST(ScheduleTest, MirrorPartnerIsTheMirrorImage) {
    Drive drive{.gamma = 3, .rho = 0.4, .phi = 4};
    for (std::size_t i = 0; i < drive.overtones.size(); ++i)
        drive.overtones.at(i) = std::polar(0.1 + 0.02 * static_cast<double>(i), static_cast<double>(i));
    const Drive partner = mirror_partner(drive);
    for (double phase = 0; phase < 6; phase += 0.1)
        EXPECT_NEAR(value_at(harmonics(partner), phase + std::numbers::pi),
                    -value_at(harmonics(drive), phase), 1e-13);
    EXPECT_NEAR(mirror_partner(partner).phi, drive.phi, 1e-15);
}

TEST(ScheduleTest, RandomIsAPermutationThatTheSeedDecides) {
    const auto with_seed = [](int seed) {
        return gammas(
            points("[[series]]\ngamma = {from = 1, to = 20, steps = 19}\nrepeats = 2\norder = \"random\"\n"
                   "seed = " +
                   std::to_string(seed) + "\n"));
    };
    const std::vector<double> once = with_seed(1);
    EXPECT_EQ(once, with_seed(1));
    EXPECT_NE(once, with_seed(2));
    std::vector<double> first{once.begin(), once.begin() + 20}, second{once.begin() + 20, once.end()};
    EXPECT_NE(first, second);
    std::ranges::sort(first);
    std::ranges::sort(second);
    EXPECT_EQ(first, second);
    EXPECT_TRUE(std::ranges::adjacent_find(first) == first.end());
}

// Campaigns continue by the numbers of their points, on any machine and after an upgrade.
TEST(ScheduleTest, RandomOrderIsTheDocumentedOne) {
    const auto order =
        gammas(points("[[series]]\ngamma = [1, 2, 3, 4, 5, 6]\norder = \"random\"\nseed = 1\n"));
    EXPECT_EQ(order, (std::vector<double>{2, 4, 1, 5, 6, 3}));
}

TEST(ScheduleTest, UpDownGoesBackOnTheSameWay) {
    const std::vector<Point> all =
        points("[[series]]\ngamma = [1, 2, 3]\norder = \"up_down\"\nrepeats = 2\n");
    EXPECT_EQ(gammas(all), (std::vector<double>{1, 2, 3, 3, 2, 1, 1, 2, 3, 3, 2, 1}));
    for (std::size_t i = 0; i < all.size(); ++i) EXPECT_EQ(all[i].repeat, static_cast<int>(i / 3) + 1);
}

TEST(ScheduleTest, TooManyPointsAreRefusedWithTheSeries) {
    const std::string text =
        "[[series]]\nname = \"small\"\n[[series]]\nname = \"large\"\nrepeats = 10000\ngamma = {from = 1, to "
        "= 2, "
        "steps = 10000}\n";
    try {
        points(text);
        FAIL() << "accepted";
    } catch (const InputError& error) {
        EXPECT_TRUE(std::string{error.what()}.starts_with(
            "p.toml:3: series \"large\": the plan has more than 10000 points"))
            << error.what();
    }
}

}  // namespace
}  // namespace shaker::campaign
