
#include "calibration/accelerometer/tumble.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "drivers/errors.hpp"
#include "tests/support/calibration/tumbled_sensor.hpp"
#include "tests/support/nightly.hpp"

namespace shaker::calibration {
namespace {

using test::TumbledSensor;

Eigen::Matrix3d matrix(const Matrix& m) {
    Eigen::Matrix3d e;
    for (Eigen::Index i = 0; i < 9; ++i)
        e(i / 3, i % 3) = m[static_cast<std::size_t>(i / 3)][static_cast<std::size_t>(i % 3)];
    return e;
}

// The sensor's true m/s^2 per count, turned as Tumble states: symmetric times nominal.
Eigen::Matrix3d true_gain(const TumbledSensor& sensor) {
    const Eigen::Matrix3d back = matrix(sensor.gain).inverse();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> squares{back.transpose() * back};
    return squares.operatorSqrt() * sensor.mps2_per_count;
}

// E and b of Tumble: what is left between a fit and the truth.
Eigen::Matrix<double, 9, 1> errors_of(const Tumble& fit, const TumbledSensor& sensor) {
    const Eigen::Matrix3d e = matrix(fit.gain) * true_gain(sensor).inverse() - Eigen::Matrix3d::Identity();
    const Eigen::Vector3d offset{fit.offset_counts[0], fit.offset_counts[1], fit.offset_counts[2]};
    const Eigen::Vector3d truth =
        -Eigen::Vector3d{sensor.offset[0], sensor.offset[1], sensor.offset[2]} / sensor.mps2_per_count;
    Eigen::Matrix<double, 9, 1> all;
    all << e(0, 0), e(1, 1), e(2, 2), (e(0, 1) + e(1, 0)) / 2, (e(0, 2) + e(2, 0)) / 2,
        (e(1, 2) + e(2, 1)) / 2, matrix(fit.gain) * (offset - truth) / sensor.gravity;
    return all;
}

Tumble fitted(TumbledSensor& sensor) {
    return fit_tumble(sensor.attitudes(standard_attitudes), sensor.nominal(), {sensor.gravity, 0});
}

std::string refusal(const std::vector<Attitude>& attitudes, const TumbledSensor& sensor) {
    try {
        static_cast<void>(fit_tumble(attitudes, sensor.nominal(), {sensor.gravity, 0}));
    } catch (const InputError& e) {
        return e.what();
    }
    return "fitted";
}

TEST(TumbleTest, RecoversExactSensorWithoutNoise) {
    TumbledSensor sensor{.mps2_per_count = 1e-8, .noise = 0};
    const Tumble fit = fitted(sensor);
    EXPECT_LT(errors_of(fit, sensor).cwiseAbs().maxCoeff(), 1e-8);  // half a count is 5e-10 g
    EXPECT_LT(fit.condition, 30);
    EXPECT_EQ(fit.degrees_of_freedom, 9);
    EXPECT_TRUE(fit.findings.empty());
}

TEST(TumbleTest, ReadsOneGravityInEveryAttitude) {
    TumbledSensor sensor;
    const Tumble fit = fitted(sensor);
    const Eigen::Vector3d offset{fit.offset_counts[0], fit.offset_counts[1], fit.offset_counts[2]};
    for (const Attitude& held : sensor.attitudes(std::array<std::string_view, 3>{"+x+y+z", "-x-y+z", "+z"})) {
        const Eigen::Vector3d counts{held.mean[0], held.mean[1], held.mean[2]};
        EXPECT_NEAR((matrix(fit.gain) * (counts + offset)).norm(), sensor.gravity, 1e-3);
    }
}

// The order's figure: 18 attitudes of 2 s at 25 ug/rtHz, gain below 0.005 % rms, 95 % inside two errors.
TEST(TumbleTest, ErrorsCoverTheTruth) {
    const int times = test::plays(200, 2000);
    TumbledSensor sensor{.rate_hz = test::nightly() ? 4000.0 : 400.0, .random = std::mt19937_64{11}};
    std::uniform_real_distribution<double> off{-0.03, 0.03}, cross{-0.01, 0.01};
    double gain_squares = 0, offset_squares = 0, inside = 0, inside_along = 0, chi2 = 0;
    for (int i = 0; i < times; ++i) {
        for (std::size_t r = 0; r < 9; ++r)
            sensor.gain[r / 3][r % 3] = r % 4 == 0 ? 1 + off(sensor.random) : cross(sensor.random);
        const Tumble fit = fitted(sensor);
        const auto e = errors_of(fit, sensor);
        for (Eigen::Index k = 0; k < 9; ++k)
            inside += std::abs(e[k]) < 1.96 * std::sqrt(fit.covariance[static_cast<std::size_t>(10 * k)]);
        std::normal_distribution<double> any;
        const Eigen::Vector3d u =
            Eigen::Vector3d{any(sensor.random), any(sensor.random), any(sensor.random)}.normalized();
        const double along = u[0] * u[0] * e[0] + u[1] * u[1] * e[1] + u[2] * u[2] * e[2] +
                             2 * (u[0] * u[1] * e[3] + u[0] * u[2] * e[4] + u[1] * u[2] * e[5]);
        gain_squares += along * along / times;
        offset_squares += e.tail<3>().squaredNorm() / 3 / times;
        inside_along += std::abs(along) < 1.96 * fit.gain_error({u[0], u[1], u[2]});
        chi2 += fit.chi2 / fit.degrees_of_freedom / times;
    }
    std::printf(
        "%d calibrations: gain %.5f %% rms, offset %.1f ug rms, inside 1.96 errors %.1f %% of 9 "
        "parameters, %.1f %% of gains along an axis, chi2/dof %.3f\n",
        times, 100 * std::sqrt(gain_squares), 1e6 * std::sqrt(offset_squares), 100 * inside / times / 9,
        100 * inside_along / times, chi2);
    EXPECT_LT(std::sqrt(gain_squares), 5e-5);
    // Binomial: 0.95 +- 4 sqrt(0.95 0.05 / n); the nine parameters of a fit are nearly independent.
    EXPECT_NEAR(inside / times / 9, 0.95, 4 * std::sqrt(0.0475 / times / 5));
    EXPECT_NEAR(inside_along / times, 0.95, 4 * std::sqrt(0.0475 / times));
    EXPECT_NEAR(chi2, 1, 4 * std::sqrt(2.0 / 9 / times) + 0.02);
}

TEST(TumbleTest, NamesMissingAttitudesOfAPlanarSet) {
    TumbledSensor sensor;
    std::vector<Attitude> planar;
    for (const char* name : {"+x", "+x+y", "+y", "-x+y", "-x", "-x-y", "-y", "+x-y", "+x", "+y"})
        planar.push_back(attitude_of(name, sensor.record(name)));
    const std::string why = refusal(planar, sensor);
    EXPECT_TRUE(why.starts_with("10 attitudes do not determine gains and offsets: the condition number is"))
        << why;
    EXPECT_TRUE(
        why.ends_with("hold the sensor also at +z, -z, +x+z, +x-z, -x+z, -x-z, +y+z, +y-z, -y+z, -y-z"))
        << why;
}

TEST(TumbleTest, RefusesSixFacesAlone) {
    TumbledSensor sensor;
    const std::array<std::string_view, 6> faces{"+x", "-x", "+y", "-y", "+z", "-z"};
    EXPECT_TRUE(refusal(sensor.attitudes(faces), sensor).starts_with("6 attitudes do not determine"));
}

TEST(TumbleTest, NamesTheAttitudeThatMoved) {
    TumbledSensor sensor;
    std::vector<Attitude> all = sensor.attitudes(standard_attitudes);
    all[6] = attitude_of("+x+y", sensor.record("+x+y", 0.1));
    EXPECT_TRUE(refusal(all, sensor).starts_with("attitude 7 (+x+y): the sensor moved: x wanders by"))
        << refusal(all, sensor);
}

TEST(TumbleTest, RefusesNoRecordOfASensorAtRest) {
    TumbledSensor sensor;
    for (int i = 0; i < test::plays(300, 3000); ++i) {
        const double g = sensor.gravity / sensor.mps2_per_count;
        const Attitude held = attitude_of("+x", sensor.record("+x"));
        ASSERT_EQ(motion_in(held, {g, g, g}), "") << i;
    }
}

TEST(TumbleTest, NamesSwappedAxesAndCorrectsThem) {
    TumbledSensor sensor, swapped;
    std::swap(swapped.gain[0], swapped.gain[1]);
    std::swap(swapped.offset[0], swapped.offset[1]);
    const Tumble fit = fitted(swapped);
    ASSERT_EQ(fit.findings.size(), 1U);
    EXPECT_EQ(fit.findings[0],
              "axes x and y are swapped against the names of the attitudes; the gain matrix corrects it");
    EXPECT_NEAR(fit.gain[0][1], true_gain(sensor)(0, 0), 1e-4 * sensor.mps2_per_count);
}

TEST(TumbleTest, NamesAFlippedAxisAndCorrectsIt) {
    TumbledSensor sensor, flipped;
    for (double& x : flipped.gain[2]) x = -x;
    const Tumble fit = fitted(flipped);
    ASSERT_EQ(fit.findings.size(), 1U);
    EXPECT_EQ(fit.findings[0],
              "axis z is flipped against the names of the attitudes; the gain matrix corrects it");
    EXPECT_NEAR(fit.gain[2][2], -true_gain(sensor)(2, 2), 1e-4 * sensor.mps2_per_count);
}

TEST(TumbleTest, NamesAnAttitudeHeldElsewhere) {
    TumbledSensor sensor;
    std::vector<Attitude> all = sensor.attitudes(standard_attitudes);
    all[6].name = "+x-y";
    const std::string why = refusal(all, sensor);
    EXPECT_TRUE(why.starts_with("attitude 7 (+x-y): the sensor was held")) << why;
    EXPECT_TRUE(why.ends_with("near +x+y; hold it again or correct its name")) << why;
}

TEST(TumbleTest, WidensErrorsWhenTheModelDoesNotHold) {
    TumbledSensor sensor;
    std::vector<Attitude> all = sensor.attitudes(standard_attitudes);
    for (double& x : all[12].mean) x *= 1.001;  // an offset that drifted away in one attitude
    const Tumble fit = fit_tumble(all, sensor.nominal(), {sensor.gravity, 0});
    ASSERT_EQ(fit.findings.size(), 1U);
    EXPECT_TRUE(fit.findings[0].ends_with("errors are widened; attitude 13 (-x+z) deviates most"))
        << fit.findings[0];
    const auto e = errors_of(fit, sensor);
    for (Eigen::Index k = 0; k < 9; ++k)
        EXPECT_LT(std::abs(e[k]), 4 * std::sqrt(fit.covariance[static_cast<std::size_t>(10 * k)])) << k;
    for (double& x : all[3].mean) x *= 1.02;
    EXPECT_TRUE(refusal(all, sensor).starts_with("the magnitude of the reading varies by"));
}

TEST(TumbleTest, ErrorOfGravityIsAnErrorOfTheGain) {
    TumbledSensor sensor;
    const auto all = sensor.attitudes(standard_attitudes);
    const Tumble fit = fit_tumble(all, sensor.nominal(), {sensor.gravity, 1e-3});
    EXPECT_NEAR(fit.gain_error({0.6, 0, 0.8}), 1e-3 / sensor.gravity, 1e-5);
}

TEST(TumbleTest, GuessesScalesOfUnequalAxes) {
    TumbledSensor sensor;
    for (double& x : sensor.gain[1]) x *= 2.5;
    sensor.offset = {};
    const auto all = sensor.attitudes(standard_attitudes);
    const Vector guess = guessed_scales(all, sensor.gravity);
    EXPECT_NEAR(guess[0] / guess[1], 2.5, 0.15);
    const Tumble fit = fit_tumble(all, guess, {sensor.gravity, 0});
    EXPECT_NEAR(fit.gain[1][1] * 2.5 * 0.987 / sensor.mps2_per_count, 1, 1e-3);
}

TEST(AttitudeTest, NamesPointUp) {
    EXPECT_EQ(direction_of("-y"), (Vector{0, -1, 0}));
    EXPECT_NEAR((*direction_of("+x-z"))[2], -std::sqrt(0.5), 1e-15);
    EXPECT_NEAR((*direction_of("-x+y+z"))[0], -std::sqrt(1.0 / 3), 1e-15);
    for (const char* name : {"", "x", "+x+x", "+w", "up", "+x+"}) EXPECT_FALSE(direction_of(name)) << name;
}

TEST(AttitudeTest, RefusesAShortRecord) {
    const std::vector<Counts> samples(99);
    EXPECT_THROW(static_cast<void>(attitude_of("+x", samples)), InputError);
}

// Published values of the WGS 84 formula: NIMA TR8350.2 (equator, pole); 45 deg from GRS tables.
TEST(NormalGravityTest, GivesPublishedValues) {
    constexpr double pi = 3.14159265358979323846;
    EXPECT_NEAR(normal_gravity(0, 0).value, 9.7803253359, 1e-9);
    EXPECT_NEAR(normal_gravity(pi / 2, 0).value, 9.8321849378, 1e-9);
    EXPECT_NEAR(normal_gravity(pi / 4, 0).value, 9.8061977, 1e-6);
    EXPECT_NEAR(normal_gravity(pi / 4, 1000).value - normal_gravity(pi / 4, 0).value, -3.0855e-3, 1e-6);
}

}  // namespace
}  // namespace shaker::calibration
