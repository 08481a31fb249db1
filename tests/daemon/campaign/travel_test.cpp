#include "daemon/campaign/travel.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>

#include "daemon/campaign/plan.hpp"
#include "tests/support/paths.hpp"

namespace shaker::campaign {
namespace {

constexpr double T = 0.05;

Drive paper(double gamma_in_g, double phi) { return {.gamma = gamma_in_g * paper_g, .phi = phi}; }

// A round drift, 20 periods of settling: every way of a pass is 1 mm times its periods, ramps included.
const Walk one_mm{.v_D = 1e-3 / T, .settling = 20};
const Timing timing{.ramp = 1, .drive_settles = 10};

TEST(TravelTest, DriftIsThatOfTheReferenceCases) {
    std::ifstream in{test::source_dir() + "/tests/golden/physics_reference.json"};
    const auto reference = nlohmann::json::parse(in);
    WalkPredictor predictor{0.113, 9.8};
    int compared = 0;
    for (const auto& c : reference.at("cases")) {
        const auto& p = c.at("params");
        const auto number = [&](const char* key) { return p.at(key).get<double>(); };
        if (number("tilt_deg") != 0 || !p.at("vertical_accel").empty() || number("g") != 9.8 ||
            number("mu_k") != 0.113 || number("mu_s") != 0.113)
            continue;
        const double frequency = number("f_hz");
        Harmonics<Acceleration> base;
        bool possible = true;
        for (const auto& h : p.at("base_accel")) {
            const int q = h.at("q");
            possible = possible && q <= 2 && (q != 1 || h.at("phase").get<double>() == 0);
            base.at(q) = std::polar(h.at("a").get<double>(), h.at("phase").get<double>());
        }
        if (!possible) continue;
        const Walk& walk = predictor.at(drive_of(base, frequency));
        const double scale = (std::abs(base.at(1)) + std::abs(base.at(2))) / (two_pi * frequency);
        EXPECT_NEAR(walk.v_D, c.at("answer").at("v_D").get<double>(), 1e-10 * scale) << c.at("name");
        ++compared;
    }
    EXPECT_GE(compared, 8);
}

TEST(TravelTest, SlowApproachNeedsTheMostSettling) {
    WalkPredictor predictor{0.113}, impatient{0.113, paper_g, 100};
    EXPECT_GT(predictor.at(paper(40, 0)).settling, 300);
    EXPECT_EQ(impatient.at(paper(40, 0)).settling, 100);
    EXPECT_LT(predictor.at(paper(0.5, 0)).settling, 12);
    EXPECT_LT(predictor.at(paper(1, 0)).settling, predictor.at(paper(3, 0)).settling);
}

TEST(TravelTest, WayIsRampsSettlingAndMeasuring) {
    const Travel t = travel({.plan = {.periods = 40}}, one_mm, timing, 0.1);
    EXPECT_TRUE(t.fits());
    EXPECT_EQ(t.passes, 1);
    EXPECT_EQ(t.measured(), 40);
    EXPECT_EQ(t.settling, 20);
    EXPECT_NEAR(t.way, 62e-3, 1e-12);
}

TEST(TravelTest, AskedSettlingFollowsTheSettledDrive) {
    EXPECT_EQ(travel({.plan = {.settle = 7}}, one_mm, timing, 0.1).settling, 17);
}

TEST(TravelTest, FitsFromFivePeriodsOn) {
    const double least = 27e-3;  // 2 ramps, 20 periods of settling, 5 measured
    const Travel fits = travel({.plan = {.periods = 40}}, one_mm, timing, least),
                 fails = travel({.plan = {.periods = 40}}, one_mm, timing, least - 1e-6);
    EXPECT_EQ(fits.passes, 8);
    EXPECT_EQ(fits.periods, 5);
    EXPECT_EQ(fits.measured(), 40);
    EXPECT_NEAR(fits.way, least, 1e-12);
    EXPECT_FALSE(fails.fits());
    EXPECT_TRUE(fails.why.starts_with("settling and 5 periods need 27.0 mm, the free way is 27.0 mm"))
        << fails.why;
    EXPECT_EQ(fails.measured(), 0);
}

TEST(TravelTest, PassesAreOfEqualLength) {
    for (int periods = 5; periods < 200; ++periods)
        for (double way = 27e-3; way < 0.12; way += 1e-3) {
            const Travel t = travel({.plan = {.periods = periods}}, one_mm, timing, way);
            ASSERT_TRUE(t.fits());
            EXPECT_GE(t.measured(), periods);
            EXPECT_GE(t.last_periods, 5);
            EXPECT_GE(t.periods, t.last_periods);
            EXPECT_LE(t.way, way + 1e-9);
            EXPECT_LT(t.measured(), periods + 5);
        }
}

TEST(TravelTest, WalkThatLeadsNowhereFits) {
    const Travel t = travel({.plan = {.periods = 1000}}, {.v_D = 0, .settling = 8}, timing, 1e-3);
    EXPECT_EQ(t.passes, 1);
    EXPECT_EQ(t.way, 0);
    EXPECT_FALSE(travel({.plan = {.periods = 40}}, {.v_D = 0}, timing, 0).fits());
}

TEST(TravelTest, PrecisionMayNeedTheMostPeriods) {
    EXPECT_EQ(travel({.precision = 1e-4, .most_periods = 70}, one_mm, timing, 1).measured(), 70);
}

TEST(TravelTest, UnknownWalkFailsWithItsReason) {
    const Travel t = travel({}, {.why = "no steady motion"}, timing, 1);
    EXPECT_FALSE(t.fits());
    EXPECT_EQ(t.why, "no steady motion");
}

TEST(LeadTest, MirrorPairComesHomeWithoutReturn) {
    const Travel there = travel({.plan = {.periods = 40}}, one_mm, timing, 0.1);
    Travel back = there;
    back.v_D = -back.v_D;
    double place = -0.031;
    const Stage first = lead(there, timing, 0.1, place), second = lead(back, timing, 0.1, place);
    EXPECT_EQ(first.returned, 0);
    EXPECT_EQ(second.returned, 0);
    EXPECT_NEAR(first.end, 0.031, 1e-12);
    EXPECT_NEAR(place, -0.031, 1e-12);
    EXPECT_NEAR(first.measuring_s, 40 * T, 1e-12);
    EXPECT_NEAR(first.settling_s, 21 * T, 1e-12);
}

TEST(LeadTest, ReturnsBeforeAPointThatLacksRoom) {
    const Travel t = travel({.plan = {.periods = 40}}, one_mm, timing, 0.1);
    double place = 0;
    const Stage stage = lead(t, timing, 0.1, place);
    EXPECT_NEAR(stage.returned, 0.031, 1e-12);
    EXPECT_NEAR(stage.begin, -0.031, 1e-12);
    EXPECT_NEAR(stage.returning_s, timing.return_s + 0.031 / timing.return_mps, 1e-9);
}

TEST(LeadTest, WalkerNeverLeavesTheFreeWay) {
    WalkPredictor predictor{0.113};
    double place = 0.02;
    for (int i = 0; i < 400; ++i) {
        const Drive drive = paper(0.2 + 0.01 * (i % 280), i);
        const double way = 0.06;
        const Stage stage =
            lead(travel({.drive = drive}, predictor.at(drive), timing, way), timing, way, place);
        EXPECT_LE(std::abs(stage.begin), way / 2 + 1e-9);
        EXPECT_LE(std::abs(stage.end), way / 2 + 1e-9);
    }
}

TEST(TravelTest, AllPointsOfThePaperInAFewTenthsOfASecond) {
    const auto points = schedule(read_plan(test::source_dir() + "/daemon/campaign/plans/paper.toml"));
    const auto start = std::chrono::steady_clock::now();
    WalkPredictor predictor{0.113};
    for (const Point& p : points) EXPECT_EQ(predictor.at(p.asked.drive).why, "");
    EXPECT_LT(std::chrono::steady_clock::now() - start,
              std::chrono::milliseconds{300 * (1 + 9 * SHAKER_SANITIZED)});
}

}  // namespace
}  // namespace shaker::campaign
