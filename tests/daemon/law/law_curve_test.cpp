#include "daemon/law/law_curve.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace shaker::law {
namespace {

constexpr calibration::Estimate mu{0.113, 0.005};
const Drive drive{.frequency = 20, .gamma = 3 * paper_g, .rho = 0.5, .phi = 0};

// Without stick both are the same motion; gamma 3 g, phi 0 gives 56.8514 mm/s.
TEST(LawCurveTest, ExactLawMeetsClosedFormWhereNothingSticks) {
    const LawCurve curve = against_gamma(drive, 3 * paper_g, 7, mu, paper_g);
    ASSERT_EQ(curve.x.size(), 7U);
    EXPECT_EQ(curve.x.front(), 0);
    EXPECT_DOUBLE_EQ(curve.x.back(), 3 * paper_g);
    EXPECT_NEAR(curve.exact.at_mu.back(), 56.8514e-3, 1e-7);
    EXPECT_NEAR(curve.closed_form.at_mu.back(), curve.exact.at_mu.back(), 1e-9);
    EXPECT_EQ(curve.exact.at_mu.front(), 0) << "a base at rest";
    EXPECT_TRUE(std::isnan(curve.closed_form.at_mu.front()));
}

// At phi 90 deg the walker sticks: 9.1560 mm/s at 1 g, where the closed form has 12.9409.
TEST(LawCurveTest, StickIsInTheExactLawOnly) {
    const Drive at{.frequency = 20, .gamma = paper_g, .rho = 0.5, .phi = 0};
    const LawCurve curve = against_phi(at, 5, mu, paper_g);
    EXPECT_DOUBLE_EQ(curve.x.front(), -std::numbers::pi);
    EXPECT_NEAR(curve.exact.at_mu.at(3), 9.1560e-3, 1e-7);
    EXPECT_NEAR(curve.closed_form.at_mu.at(3), 12.9409e-3, 1e-7);
}

TEST(LawCurveTest, BandIsThatOfMuAndClosesWithoutError) {
    const LawCurve curve = against_gamma(drive, 3 * paper_g, 3, mu, paper_g);
    const double below =
        against_gamma(drive, 3 * paper_g, 3, {mu.value - mu.sigma, 0}, paper_g).exact.at_mu.back();
    const double above =
        against_gamma(drive, 3 * paper_g, 3, {mu.value + mu.sigma, 0}, paper_g).exact.at_mu.back();
    EXPECT_EQ(curve.exact.low.back(), std::min(below, above));
    EXPECT_EQ(curve.exact.high.back(), std::max(below, above));
    const LawCurve certain = against_gamma(drive, 3 * paper_g, 3, {mu.value, NAN}, paper_g);
    EXPECT_EQ(certain.exact.low.back(), certain.exact.high.back());
}

}  // namespace
}  // namespace shaker::law
