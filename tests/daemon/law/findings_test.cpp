#include "daemon/law/findings.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "tests/support/law/synthetic_points.hpp"

namespace shaker::law {
namespace {

constexpr Coulomb bench{.mu = 0.113, .tilt = 5e-4, .push = 0.1};

TEST(AskedDriveTest, GivesTheDriftOnTheAskedDrive) {
    const Findings f = analyse(test::exact_points(bench));
    for (std::size_t i = 0; i < f.points.size(); ++i) {
        ASSERT_EQ(f.asked[i].reason, "");
        const Drive& asked = f.points[i].asked;
        const double ideal = pushed_cycle(harmonics(asked), asked.frequency, {.mu = 0.113}).v_D;
        EXPECT_NEAR(f.asked[i].v_D.value, ideal, 2e-8);
        EXPECT_GT(std::abs(f.asked[i].correction), 1e-5);
        EXPECT_GT(f.asked[i].model_error, 0);
        EXPECT_NEAR(f.asked[i].v_D.sigma, std::hypot(f.asked[i].model_error, 1e-6), 1e-12);
    }
}

TEST(AskedDriveTest, IsNotGivenWhereTheLawDoesNotHold) {
    std::vector<Point> points = test::exact_points(bench);
    const CoulombFit fit = fit_coulomb(points);
    LawPoint at = fit.points[0];
    at.z = 4.5;
    EXPECT_NE(on_asked_drive(points[0], at, fit).reason.find("misses v_D by 4.5 errors"), std::string::npos);
    at.z = 0;
    points[0].asked.phi += 1;
    const AskedDrive far = on_asked_drive(points[0], at, fit);
    EXPECT_NE(far.reason.find("of gamma/omega"), std::string::npos) << far.reason;
    EXPECT_TRUE(std::isnan(far.v_D.value));
    EXPECT_TRUE(std::isfinite(far.correction));
    EXPECT_NE(on_asked_drive(points[0], {}, fit_coulomb({})).reason.find("mu is not known"),
              std::string::npos);
}

TEST(FindingsTest, JsonHasFitsBudgetsAndPoints) {
    const Findings f = analyse(test::exact_points(bench));
    const auto j = nlohmann::json::parse(findings_json(f));
    EXPECT_EQ(j.at("fits").at(0).at("name"), "mu_ac");
    EXPECT_NEAR(j.at("fits").at(0).at("value").get<double>(), 0.113, 1e-6);
    for (const auto& fit : j.at("fits"))
        for (const char* key : {"name", "value", "error", "unit", "chi2", "points", "note"})
            EXPECT_TRUE(fit.contains(key)) << key;
    EXPECT_EQ(j.at("budgets").at("mu_ac").size(), 7U);
    EXPECT_EQ(j.at("points").size(), 12U);
    EXPECT_EQ(j.at("covariances").at(0).at("names").size(), 2U);
}

TEST(FindingsTest, TruthIsWhereTheTrueDriftIsZero) {
    std::vector<Point> points = test::exact_points(bench);
    const Findings without = analyse(points);
    ASSERT_FALSE(without.nulls.empty());
    EXPECT_TRUE(std::isnan(without.nulls[0].truth));
    for (Point& p : points) {
        p.true_v_D = p.v_D.value;
        p.v_D.value += 1e-5 * std::cos(p.phi.value);
    }
    const Findings with = analyse(points);
    EXPECT_EQ(with.nulls[0].truth, without.nulls[0].value);
    EXPECT_NE(with.nulls[0].truth, with.nulls[0].value);
    EXPECT_TRUE(std::isnan(with.no_stick.truth)) << "Eq. (8) is not the law of a walker";
    for (const CosineFit& c : with.cosines) EXPECT_TRUE(std::isnan(c.amplitude.truth));
    EXPECT_TRUE(std::isnan(with.slopes.mu.truth));
}

TEST(FindingsTest, TiltOfTheDriftIsComparedWithGravity) {
    std::vector<Point> points = test::exact_points({.mu = 0.113, .tilt = 1.7e-3});
    EXPECT_NE(analyse(points).gravity_tilt.note.find("not known"), std::string::npos);
    for (Point& p : points) p.tilt = {1.6e-3, 3e-5};
    EXPECT_EQ(analyse(points).gravity_tilt.note, "");
    for (Point& p : points) p.tilt = {2e-5, 3e-5};
    const Fit apart = analyse(points).gravity_tilt;
    EXPECT_NEAR(apart.value, 2e-5, 1e-12);
    EXPECT_NE(apart.note.find("friction that is 3 % larger backwards"), std::string::npos) << apart.note;
}

TEST(FindingsTest, TextHasEachMuWithItsBudget) {
    const std::string text = findings_text(analyse(test::exact_points(bench)));
    for (const char* part :
         {"mu_ac", "mu_k", "mu_ns", "tilt", "m/M_eff", "budget of mu_ac", "13 to 23 % below"})
        EXPECT_NE(text.find(part), std::string::npos) << part;
    EXPECT_TRUE(text.ends_with('\n'));
}

TEST(FindingsTest, NoPointsGiveReasons) {
    const Findings f = analyse({});
    EXPECT_NE(f.coulomb.mu.note, "");
    EXPECT_NE(f.slopes.mu.note, "");
    EXPECT_NE(f.no_stick.note, "");
    EXPECT_NO_THROW(nlohmann::json::parse(findings_json(f)));
}

}  // namespace
}  // namespace shaker::law
