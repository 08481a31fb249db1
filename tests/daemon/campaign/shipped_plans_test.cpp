// The plans of the package, and the page that describes plans.
#include <gtest/gtest.h>
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <numbers>
#include <set>
#include <sstream>

#include "daemon/campaign/plan.hpp"
#include "drivers/walker/no_stick.hpp"
#include "tests/support/paths.hpp"

namespace shaker::campaign {
namespace {

const std::string folder = test::source_dir() + "/daemon/campaign/";

std::vector<Point> shipped(const std::string& name) {
    return schedule(read_plan(folder + "plans/" + name + ".toml"));
}

// Points of each series, by the first word of its name.
std::map<std::string, int> counts(const std::vector<Point>& points) {
    std::map<std::string, int> list;
    for (const Point& p : points) ++list[p.series.substr(0, p.series.find(' '))];
    return list;
}

TEST(ShippedPlansTest, PaperHas228PointsOf144SetPoints) {
    const std::vector<Point> points = shipped("paper");
    EXPECT_EQ(points.size(), 228U);
    EXPECT_EQ(counts(points), (std::map<std::string, int>{{"2b", 96}, {"3a", 36}, {"3b", 96}}));
    const auto in_figure = [](const Point& p) {  // others are there as mirror partners only
        if (p.series == "2b") return p.asked.drive.phi < std::numbers::pi + 1e-9;
        return p.series == "3a" || p.id < p.partner;
    };
    EXPECT_EQ(std::ranges::count_if(points, in_figure), 144);
}

TEST(ShippedPlansTest, FiguresHaveTheirPoints) {
    EXPECT_EQ(counts(shipped("fig2")), (std::map<std::string, int>{{"2b", 96}}));
    EXPECT_EQ(counts(shipped("fig3")), (std::map<std::string, int>{{"3a", 36}, {"3b", 96}}));
    EXPECT_EQ(counts(shipped("fig4")), (std::map<std::string, int>{{"4", 96}}));
    EXPECT_EQ(shipped("mu").size(), 24U);
}

TEST(ShippedPlansTest, Fig3aHasTwelvePhasesAtEachGamma) {
    std::map<long, std::set<long>> phases;
    for (const Point& p : shipped("fig3"))
        if (p.series == "3a")
            phases[std::lround(100 * p.asked.drive.gamma / paper_g)].insert(
                std::lround(p.asked.drive.phi * 360 / two_pi));
    const std::set<long> circle{0, 30, 60, 90, 120, 150, 180, 210, 240, 270, 300, 330};
    EXPECT_EQ(phases, (std::map<long, std::set<long>>{{68, circle}, {100, circle}, {300, circle}}));
}

TEST(ShippedPlansTest, NullPhasesLieWithinTheirSixPhases) {
    for (const char* plan : {"paper", "fig3", "mu"}) {
        std::map<double, std::vector<double>> phases;
        for (const Point& p : shipped(plan))
            if (p.id < p.partner && p.series != "2b" && p.series != "3a")
                phases[p.asked.drive.gamma].push_back(p.asked.drive.phi);
        EXPECT_EQ(phases.size(), plan == std::string{"mu"} ? 3U : 8U);
        for (const auto& [gamma, list] : phases) {
            const double null = std::numbers::pi / 2 + walker::coulomb_theta(gamma / (0.113 * paper_g));
            EXPECT_NEAR(list.front(), null - 0.3, 0.006);
            EXPECT_NEAR(list.back(), null + 0.3, 0.006);
        }
    }
}

std::string page() {
    std::ifstream in{folder + "README.md"};
    std::ostringstream text;
    text << in.rdbuf();
    return text.str();
}

std::string row(const PointField& field) {
    constexpr std::array units{" m/s^2", " rad", " Hz", " s", " m/s", " m", ""};  // by Dimension
    const auto number = [&](double x) {
        return field.whole() ? fmt::format("{:.0f}", x) : fmt::format("{:.6g}", x);
    };
    return fmt::format("| `{}` | {} to {}{} | {} | {} |\n", field.name, number(field.allowed.min),
                       number(field.allowed.max), units.at(static_cast<std::size_t>(field.dimension)),
                       field.standard.empty() ? "-" : field.standard, field.help);
}

TEST(PlanPageTest, HasTheTableOfTheFields) {
    std::string rows;
    for (const PointField& field : point_fields) rows += row(field);
    EXPECT_NE(page().find("|---|---|---|---|\n" + rows), std::string::npos) << rows;
}

// The defaults of the table are those of the code.
TEST(PlanPageTest, DefaultsAreThoseOfAPoint) {
    for (const PointField& field : point_fields) {
        if (field.standard.empty()) continue;
        EXPECT_EQ(field.in(PointSettings{}),
                  parse_quantity(field.name, field.standard, field.dimension, field.allowed))
            << field.name;
    }
}

TEST(PlanPageTest, ItsExampleIsAPlan) {
    const std::string text = page();
    const auto from = text.find("```toml\n") + 8;
    const Plan plan = parse_plan(text.substr(from, text.find("```", from) - from), "README.md");
    EXPECT_EQ(plan.series.size(), 4U);
    EXPECT_NE(text.find(fmt::format("{} points", schedule(plan).size())), std::string::npos)
        << schedule(plan).size();
}

TEST(PlanPageTest, EveryShippedPlanIsNamed) {
    for (const auto& file : std::filesystem::directory_iterator{folder + "plans"})
        EXPECT_NE(page().find("`" + file.path().filename().string() + "`"), std::string::npos) << file.path();
}

}  // namespace
}  // namespace shaker::campaign
