// Laws of friction, distinguished on points of an independent walker.
#include "daemon/law/verdict.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "tests/support/law/stepped_walker.hpp"
#include "tests/support/law/synthetic_points.hpp"

namespace shaker::law {
namespace {

LawSetting usual_setting() {
    LawSetting s;
    s.friction.mu_k = 0.113;
    s.push = 0.03;
    s.tilt = 2e-4;
    return s;
}

struct LawScene {
    std::string_view law;
    std::vector<double> parameters;
};

const Law& law_named(std::string_view name) { return *std::ranges::find(laws, name, &Law::name); }

LawSetting setting_of(const LawScene& scene) {
    LawSetting s = usual_setting();
    const Law& law = law_named(scene.law);
    s.friction.law = law.friction;
    for (std::size_t i = 0; i < scene.parameters.size(); ++i) law.parameters[i].set(s, scene.parameters[i]);
    return s;
}

Verdict judged(const std::vector<Point>& points, calibration::Estimate tilt = {2e-4, 3e-5}) {
    return judge(points, {}, tilt);
}

class VerdictTest : public testing::TestWithParam<LawScene> {};

TEST_P(VerdictTest, NamesTheLawOfTheWalkerAndItsParameters) {
    const LawScene& scene = GetParam();
    std::vector<Point> points = test::stepped_points(setting_of(scene), 20'000);
    std::mt19937_64 random{5};
    test::add_noise(points, random);
    const Verdict v = judged(points);
    SCOPED_TRACE(verdict_text(v));
    ASSERT_TRUE(v.chosen);
    const LawFit& fit = v.fits[*v.chosen];
    EXPECT_EQ(fit.law->name, scene.law);
    EXPECT_FALSE(v.refused);
    EXPECT_TRUE(v.rivals.empty());
    const double slope = scene.law == "place" ? scene.parameters[0] : 0;  // mu is that of the mean place
    EXPECT_NEAR(fit.mu.value, 0.113 * (1 + slope * fit.setting.middle), 4 * fit.mu.error + 2e-6);
    EXPECT_LT(fit.mu.error, 0.01 * 0.113);
    ASSERT_EQ(fit.parameters.size(), scene.parameters.size());
    for (std::size_t i = 0; i < scene.parameters.size(); ++i)
        EXPECT_NEAR(fit.parameters[i].value, scene.parameters[i],
                    4 * fit.parameters[i].error + 1e-4 * std::abs(scene.parameters[i]))
            << fit.parameters[i].name;
}

INSTANTIATE_TEST_SUITE_P(Laws, VerdictTest,
                         testing::Values(LawScene{"coulomb", {}}, LawScene{"static", {1.3}},
                                         LawScene{"viscous", {3.5}}, LawScene{"logarithmic", {0.05}},
                                         LawScene{"dahl", {7.2e-6}}, LawScene{"unequal", {1.03}},
                                         LawScene{"place", {1.0}}, LawScene{"dahl_viscous", {7.2e-6, 4.2}},
                                         LawScene{"stribeck", {1.3, 0.02}}, LawScene{"time", {0.05, 60}},
                                         LawScene{"vertical", {0.005, 0.01}}),
                         [](const auto& scene) { return std::string{scene.param.law}; });

std::vector<Point> coulomb_points() {
    std::vector<Point> points = test::exact_points({.mu = 0.113, .push = 0.05});
    std::mt19937_64 random{8};
    test::add_noise(points, random);
    return points;
}

// The tilt by gravity counts with its error, also without mirror partners.
TEST(VerdictPointsTest, TiltByGravityIsADatum) {
    std::vector<Point> points = coulomb_points();
    for (Point& p : points) p.partner = 0;
    const Verdict v = judge(points, {}, {2e-4, 2e-4});
    ASSERT_TRUE(v.chosen);
    EXPECT_EQ(v.fits[*v.chosen].law->name, "coulomb") << verdict_text(v);
    EXPECT_NEAR(v.fits[0].tilt.value, 0, 5 * v.fits[0].tilt.error);
    const Verdict level = judge(points, {.free_tilt = false}, {1.5e-3, 5e-5});
    EXPECT_FALSE(level.refused) << verdict_text(level);
    EXPECT_TRUE(std::isnan(level.fits[0].tilt.value));
    EXPECT_NE(level.sentence.find("not judged: Coulomb with unequal directions"), std::string::npos)
        << level.sentence;
}

// Hundreds of harmonics that fit do not hide velocities that do not.
TEST(VerdictPointsTest, ScatterOfTheVelocitiesIsNoLaw) {
    std::vector<Point> points = coulomb_points();
    for (std::size_t i = 0; i < points.size(); ++i) points[i].v_D.value += (i % 3 == 0 ? 1 : -1) * 2e-5;
    const Verdict v = judge(points, {}, {});
    EXPECT_TRUE(v.refused) << verdict_text(v);
    EXPECT_TRUE(v.sentence.starts_with("no law of the list describes these points; nearest: ")) << v.sentence;
}

TEST(VerdictPointsTest, EvenPartKeepsMirrorPartnersTogether) {
    std::vector<Point> points;
    for (int n = 1; n <= 720; ++n) points.push_back({.number = n, .partner = n % 2 == 1 ? n + 1 : n - 1});
    const std::vector<Point> part = evenly(points, 300);
    EXPECT_NEAR(static_cast<double>(part.size()), 300, 2);
    for (std::size_t i = 0; i < part.size(); i += 2) EXPECT_EQ(part[i + 1].number, part[i].partner);
    EXPECT_GT(part.back().number, 700);
    EXPECT_EQ(evenly(points, 720).size(), 720U);
}

// A doubt of one measurement, and a base that something else moves, stand in the sentence.
TEST(VerdictPointsTest, DoubtsStandInTheSentence) {
    std::vector<Point> points = coulomb_points();
    points[3].doubt = "the bench check has an alarm";
    for (Point& p : points) p.base.at(12) += 0.1;
    const Verdict v = judge(points, {}, {});
    EXPECT_FALSE(v.harmonics);
    EXPECT_NE(
        v.sentence.find("the measurements of 1 of 12 points are in doubt, so is this (point 4: the bench "
                        "check has an alarm)"),
        std::string::npos)
        << v.sentence;
    EXPECT_NE(v.sentence.find("harmonics 9 to 16 of the base are not used"), std::string::npos) << v.sentence;
}

TEST(VerdictPointsTest, TooFewPointsHaveTheReason) {
    const std::vector<Point> points = test::exact_points({.mu = 0.113});
    const Verdict v = judge(std::span{points}.first(2), {}, {});
    EXPECT_FALSE(v.chosen);
    EXPECT_EQ(v.sentence, "no law was fitted: 2 of 2 points move; at least 3 are needed");
    EXPECT_TRUE(verdict_json(v)["chosen"].is_null());
}

}  // namespace
}  // namespace shaker::law
