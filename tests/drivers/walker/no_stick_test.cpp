#include "drivers/walker/no_stick.hpp"

#include <gtest/gtest.h>

#include "drivers/walker/steady_state.hpp"
#include "tests/support/walker/walker_settings.hpp"

namespace shaker::walker {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double mu = 0.113;

Harmonics<Acceleration> biharmonic(double gamma_in_g, double phi, double rho = 0.5) {
    return harmonics(Drive{.gamma = gamma_in_g * paper_g, .rho = rho, .phi = phi});
}

TEST(NoStickTest, FollowsTheClosedFormForAnyRho) {
    for (const double rho : {0.3, 0.5, 0.7, 0.9}) {
        for (const double phi : {0.0, 0.8, pi / 2, 2.5, -2.0}) {
            const double gamma = 2 * paper_g, omega = two_pi * 20, theta = no_stick_theta(gamma, mu, rho);
            const NoStick ns = no_stick(biharmonic(2, phi, rho), 20, mu);
            const double v_D = gamma * (1 - rho) / (2 * omega) * std::cos(phi - theta);
            EXPECT_NEAR(ns.v_D, v_D, 1e-15);
            EXPECT_NEAR(ns.theta, theta, 1e-14);
            EXPECT_NEAR(two_pi * ns.t0, theta == 0 ? 0 : std::acos(std::sin(theta / 2)), 1e-13);
            const double ratio = 2 * std::sqrt((4 * rho * rho + (1 - rho) * (1 - rho)) / 8);
            EXPECT_NEAR(ns.efficiency, (1 - rho) * std::abs(std::cos(phi - theta)) / ratio, 1e-13);
        }
    }
}

TEST(NoStickTest, EqualsExactWalkerExactlyWhereValid) {
    std::mt19937_64 random{11};
    int valid = 0;
    for (int i = 0; i < 400; ++i) {
        walker::WalkerSetting s = paper_setting(std::exp(uniform(random, -1, 3)), uniform(random, -pi, pi),
                                                uniform(random, 0.2, 0.95));
        const NoStick ns = no_stick(s.base, s.frequency, mu);
        const walker::WalkerLaw law{s};
        const walker::SteadyState exact = settle(law);
        const bool two_slips = exact.rest.empty() && exact.events.size() == 2;
        EXPECT_EQ(ns.valid, two_slips) << i << ": " << ns.reason;
        EXPECT_EQ(ns.valid, ns.reason.empty());
        if (!ns.valid) continue;
        EXPECT_NEAR(ns.v_D, exact.v_D, 1e-12 * law.velocity_scale());
        ++valid;
    }
    EXPECT_GT(valid, 50);
    EXPECT_LT(valid, 350);
}

TEST(NoStickTest, ChoosesValidShiftTimeAmongSeveral) {
    std::mt19937_64 random{12};
    int valid = 0;
    for (int i = 0; i < 400; ++i) {
        walker::WalkerSetting s;
        s.base = random_harmonics(random, 3 + i % 6, 3 * paper_g);
        s.base.at(1) *= 3;
        const NoStick ns = no_stick(s.base, s.frequency, mu);
        const walker::WalkerLaw law{s};
        const walker::SteadyState exact = settle(law);
        EXPECT_EQ(ns.valid, exact.rest.empty() && exact.events.size() == 2) << i << ": " << ns.reason;
        if (!ns.valid) continue;
        EXPECT_NEAR(ns.v_D, exact.v_D, 1e-12 * law.velocity_scale());
        ++valid;
    }
    EXPECT_GT(valid, 20);
}

TEST(NoStickTest, DriftIsShiftTimePlusQuarterPeriodOfFriction) {
    const NoStick ns = no_stick(biharmonic(3, 0.2), 20, mu);
    const walker::WalkerLaw law{paper_setting(3, 0.2)};
    EXPECT_NEAR(ns.v_D, law.v_base(two_pi * ns.t0) + mu * paper_g / 20 / 4, 1e-15);
}

TEST(NoStickTest, OddHarmonicsAloneHaveNoDrift) {
    Harmonics<Acceleration> base;
    base.at(1) = 20;
    base.at(3) = {3, 4};
    EXPECT_EQ(no_stick(base, 20, mu).v_D, 0);
}

TEST(NoStickTest, ReportsMissingShiftTime) {
    const NoStick weak = no_stick(biharmonic(0.354, 0), 20, mu);  // a shift time needs 0.355 g
    EXPECT_FALSE(weak.valid);
    EXPECT_TRUE(std::isnan(weak.v_D) && std::isnan(weak.t0) && std::isnan(weak.theta));
    EXPECT_NE(weak.reason.find("must stick"), std::string::npos);
    EXPECT_TRUE(std::isfinite(no_stick(biharmonic(0.356, 0), 20, mu).t0));
    const NoStick even = no_stick(biharmonic(5, 0, 0), 20, mu);
    EXPECT_NE(even.reason.find("no odd harmonic"), std::string::npos);
    EXPECT_FALSE(no_stick({}, 20, mu).valid);
}

TEST(NoStickTest, IsNeverValidAtItsOwnNull) {
    for (const double gamma : {0.5, 1.0, 3.0, 30.0}) {
        const double phi = no_stick_theta(gamma * paper_g, mu) + pi / 2;
        EXPECT_FALSE(no_stick(biharmonic(gamma, phi), 20, mu).valid);
    }
}

TEST(NoStickTest, ValidPhasesMatchExactWalkerAtOneG) {
    EXPECT_TRUE(no_stick(biharmonic(1, -2.9 * pi / 180), 20, mu).valid);
    EXPECT_TRUE(no_stick(biharmonic(1, 8.9 * pi / 180), 20, mu).valid);
    EXPECT_FALSE(no_stick(biharmonic(1, -4 * pi / 180), 20, mu).valid);
    EXPECT_FALSE(no_stick(biharmonic(1, 10 * pi / 180), 20, mu).valid);
}

TEST(NoStickTest, RmsVelocityMatchesClosedForm) {
    const double V = paper_g / (two_pi * 20);
    EXPECT_NEAR(v_rms(biharmonic(1, 1.3), 20), std::sqrt(5.0 / 32) * V, 1e-15);
    EXPECT_NEAR(v_rms(biharmonic(1, 0.4, 0.7), 20), V * std::sqrt((4 * 0.49 + 0.09) / 8), 1e-15);
}

TEST(NoStickTest, ThetaAndItsInverseAgree) {
    EXPECT_NEAR(mu_from_no_stick_theta(no_stick_theta(9.8, mu, 0.6), 9.8, 0.6), mu, 1e-15);
    EXPECT_TRUE(std::isnan(no_stick_theta(3, mu)));
}

TEST(CoulombThetaTest, MatchesTabulatedRelation) {
    const double known[][2] = {{3, 1.43174},  {4, 1.17013},  {5, 0.98126},  {6, 0.84322}, {8, 0.65724},
                               {10, 0.53837}, {15, 0.37105}, {20, 0.28336}, {30, 0.19275}};
    for (const auto& [Gamma, theta] : known) EXPECT_NEAR(coulomb_theta(Gamma), theta, 0.51e-5);
}

TEST(CoulombThetaTest, MatchesNullOfExactWalker) {
    for (double Gamma = 2.5; Gamma <= 1000; Gamma *= 1.13) {
        const auto drift = [&](double theta) {
            return settle(walker::WalkerLaw{paper_setting(Gamma * mu, theta + pi / 2)}).v_D;
        };
        // 1e-7 of Theta to either side v_D has changed from forward to backward.
        const double theta = coulomb_theta(Gamma);
        EXPECT_GT(drift(theta * (1 - 1e-7)), 0) << Gamma;
        EXPECT_LT(drift(theta * (1 + 1e-7)), 0) << Gamma;
    }
}

TEST(CoulombThetaTest, IsNaNOutsideItsRange) {
    EXPECT_TRUE(std::isnan(coulomb_theta(2.49)));
    EXPECT_TRUE(std::isnan(coulomb_theta(1001)));
    EXPECT_TRUE(std::isnan(coulomb_theta(NAN)));
    EXPECT_FALSE(std::isnan(coulomb_theta(2.5)));
    EXPECT_FALSE(std::isnan(coulomb_theta(1000)));
}

TEST(CoulombThetaTest, NoStickFormulaGivesTooSmallMuForExactData) {
    double sum = 0;
    const double gammas[] = {0.5, 0.68, 1, 2, 3};
    for (const double gamma : gammas) {
        const double read = mu_from_no_stick_theta(coulomb_theta(gamma / mu), gamma * paper_g);
        EXPECT_LT(read, mu);
        sum += read;
    }
    EXPECT_NEAR(sum / std::size(gammas), 0.09, 0.01);
}

}  // namespace
}  // namespace shaker::walker
