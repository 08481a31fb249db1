// Response of a sensor from its lines: found, as exact as stated, and no kind that the lines do not show.
#include "calibration/accelerometer/response_fit.hpp"

#include <gtest/gtest.h>

#include <cstdio>
#include <numbers>
#include <random>

#include "drivers/drive.hpp"
#include "drivers/errors.hpp"

namespace shaker::calibration {
namespace {

/// Lines of two drives of 8 harmonics of 1 m/s^2 each: 30 s by two cameras with 2 um, 1000 frames/s.
std::vector<ResponseLine> lines_of(const SensorResponse& truth, std::mt19937_64& random) {
    std::normal_distribution<double> normal;
    std::vector<ResponseLine> lines;
    int run = 0;
    for (const double f : {5.0, 25.0}) {
        const double delay = 1e-3 * normal(random);
        for (int q = 1; q <= 8; ++q) {
            const double hz = q * f, w = two_pi * hz, a = 1;
            const double sd = std::hypot(1.2e-8 * w * w / a, 1e-4 / a);
            const std::complex<double> h = truth.at(hz);
            lines.push_back(
                {.run = run,
                 .hz = hz,
                 .log_gain = {std::log(std::abs(h)) + 0.01 + sd * normal(random), sd},
                 .lead_rad = {std::remainder(std::arg(h) - w * delay + sd * normal(random), two_pi), sd}});
        }
        ++run;
    }
    return lines;
}

TEST(ResponseFitTest, CornerAndPhiAreAsExactAsStated) {
    std::mt19937_64 random{20261129};
    const auto uniform = [&](double a, double b) { return std::uniform_real_distribution{a, b}(random); };
    constexpr int n = 200;
    int corners = 0, phis = 0, kinds = 0;
    double worst = 0, z2 = 0;
    for (int i = 0; i < n; ++i) {
        SensorResponse truth;
        truth.lower = {.hz = 0.1 * std::exp(uniform(0, std::log(30))), .poles = uniform(0, 1) < 0.6 ? 1 : 2};
        if (truth.lower.poles == 2 && uniform(0, 1) < 0.5) truth.lower.damping = std::numbers::sqrt2 / 2;
        if (uniform(0, 1) < 0.7) truth.upper = {.hz = 300 * std::exp(uniform(0, std::log(7)))};
        const FittedResponse fit = fit_response(lines_of(truth, random), false);
        const LowerCorner& corner = fit.response.lower;
        const bool same = corner.poles == truth.lower.poles && corner.damping == truth.lower.damping;
        kinds += same;
        if (same) corners += std::abs(corner.hz - truth.lower.hz) < 2 * corner.error_hz;
        const auto turn = [](const SensorResponse& r) {
            return phi_turned(r.lower, 20) + phi_turned(r.upper, 20);
        };
        const double off = turn(fit.response) - turn(truth),
                     error = std::hypot(phi_turned_by_hz(corner, 20) * corner.error_hz,
                                        fit.response.upper.phi_error(20));
        phis += std::abs(off) < 2 * error;
        worst = std::max(worst, std::abs(off));
        z2 += std::pow(off / error, 2) / n;
    }
    std::printf("kinds %d of %d, corners %d of %d, phi %d of %d, worst %.2f mrad\n", kinds, n, corners, kinds,
                phis, n, 1e3 * worst);
    EXPECT_LT(worst, 0.4e-3);
    EXPECT_GT(z2, 0.3) << "errors are not much larger than needed";
    EXPECT_GE(kinds, 150);
    EXPECT_GE(corners, 0.954 * kinds - 2.5 * std::sqrt(0.954 * 0.046 * kinds));
    EXPECT_GE(phis, 0.954 * n - 2.5 * std::sqrt(0.954 * 0.046 * n));
}

TEST(ResponseFitTest, ASensorWithGravityHasNoLowerCorner) {
    std::mt19937_64 random{3};
    const FittedResponse fit = fit_response(lines_of({.upper = {.hz = 400}}, random), true);
    EXPECT_TRUE(fit.response.lower.none());
    EXPECT_NEAR(fit.response.upper.hz, 400, 3 * fit.response.upper.error_hz);
    EXPECT_LT(fit.response.upper.error_hz, 40);
    EXPECT_EQ(fit.response.upper.above_hz, 0);
}

TEST(ResponseFitTest, ALowPassThatTheLinesDoNotShowIsABound) {
    std::mt19937_64 random{4};
    const FittedResponse fit = fit_response(lines_of({.upper = {.hz = 8000}}, random), true);
    EXPECT_TRUE(fit.response.upper.none());
    EXPECT_GT(fit.response.upper.above_hz, 400);
    EXPECT_LT(fit.response.upper.above_hz, 8000);
}

TEST(ResponseFitTest, NoCornerIsStatedWithItsError) {
    std::mt19937_64 random{5};
    const FittedResponse fit = fit_response(lines_of({}, random), false);
    EXPECT_LT(fit.response.lower.hz, 3 * fit.response.lower.error_hz + 1e-9);
    EXPECT_GT(fit.response.lower.error_hz, 0);
    EXPECT_LT(fit.response.lower.error_hz, 0.02);
}

// One run of another sensor: the kinds are no longer told apart as if its errors were noise.
TEST(ResponseFitTest, LinesThatNoModelDescribesHaveWiderErrors) {
    std::mt19937_64 random{6};
    std::vector<ResponseLine> lines = lines_of({.lower = {.hz = 0.5}}, random);
    const FittedResponse right = fit_response(lines, false);
    for (ResponseLine& line : lines)
        if (line.run == 1) line.lead_rad.value += 0.5 / line.hz;
    const FittedResponse wrong = fit_response(lines, false);
    EXPECT_LT(right.chi2, 2 * right.freedom);
    EXPECT_GT(wrong.chi2, 10 * wrong.freedom);
    EXPECT_GT(wrong.response.lower.error_hz, 3 * right.response.lower.error_hz);
}

TEST(ResponseFitTest, RefusesLinesAtOneFrequency) {
    const std::vector<ResponseLine> one(3, {.hz = 20, .log_gain = {0, 1e-3}, .lead_rad = {0, 1e-3}});
    try {
        fit_response(one, false);
        FAIL();
    } catch (const InputError& error) {
        EXPECT_NE(std::string{error.what()}.find("2 or more frequencies"), std::string::npos) << error.what();
    }
}

}  // namespace
}  // namespace shaker::calibration
