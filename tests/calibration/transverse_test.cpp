#include "calibration/accelerometer/transverse.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <random>

namespace shaker::calibration {
namespace {

using Vector = std::array<double, 3>;

double dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

// Transverse motion for complex amplitudes on the sensor's axes.
Transverse of(const std::array<std::complex<double>, 3>& a, const Vector& axis, double sd = 0) {
    const auto on = [&](const Vector& u) { return a[0] * u[0] + a[1] * u[1] + a[2] * u[2]; };
    const auto [first, second] = across_axes(axis);
    return transverse(on(axis), {on(first), on(second)}, axis, sd);
}

TEST(TransverseTest, AxesFormARightHandedSet) {
    for (const Vector& u : {Vector{1, 0, 0}, Vector{0, 1, 0}, Vector{0, 0, -1}, Vector{0.6, -0.48, 0.64}}) {
        const auto [a, b] = across_axes(u);
        EXPECT_NEAR(dot(a, a), 1, 1e-14);
        EXPECT_NEAR(dot(b, b), 1, 1e-14);
        EXPECT_NEAR(dot(a, b), 0, 1e-14);
        EXPECT_NEAR(u[0] * (a[1] * b[2] - a[2] * b[1]) + u[1] * (a[2] * b[0] - a[0] * b[2]) +
                        u[2] * (a[0] * b[1] - a[1] * b[0]),
                    1, 1e-14);
    }
}

TEST(TransverseTest, SeparatesTurnedSensorFromRocking) {
    using namespace std::complex_literals;
    const std::complex<double> along = std::polar(9.8, 0.7);
    const Transverse turned = of({along, 0.03 * along, 0}, {1, 0, 0});
    EXPECT_NEAR(turned.share.value, 0.03, 1e-12);
    EXPECT_NEAR(turned.amplitude.value, 0.03 * 9.8, 1e-12);
    EXPECT_NEAR(turned.in_phase, 0.03, 1e-12);
    EXPECT_NEAR(turned.quadrature, 0, 1e-12);
    EXPECT_NEAR(std::abs(turned.direction[1]), 1, 1e-9);
    const Transverse rocks = of({along, 0.01 * along, 0.04i * along}, {1, 0, 0});
    EXPECT_NEAR(rocks.share.value, std::hypot(0.01, 0.04), 1e-12);
    EXPECT_NEAR(rocks.in_phase, 0.01, 1e-12);
    EXPECT_NEAR(rocks.quadrature, 0.04, 1e-12);
    EXPECT_NEAR(rocks.direction[2], 1, 1e-9);  // the ellipse's longer axis, positive
}

TEST(TransverseTest, DirectionDoesNotDependOnTheSensorsMounting) {
    using namespace std::complex_literals;
    const Vector u{0.36, 0.48, 0.8}, w{0.8, -0.6, 0};  // perpendicular
    std::array<std::complex<double>, 3> a;
    for (std::size_t k = 0; k < 3; ++k) a[k] = 5.0 * u[k] + 0.1 * (0.6 + 0.8i) * w[k];
    const Transverse t = of(a, u);
    EXPECT_NEAR(t.share.value, 0.02, 1e-12);
    EXPECT_NEAR(std::abs(dot(t.direction, w)), 1, 1e-9);
}

// The scatter of a share far above the noise must equal its sigma; 400 draws determine it to 3.5 %.
TEST(TransverseTest, SigmaMatchesScatterUnderNoise) {
    std::mt19937_64 rng{1};
    const double sd = 0.02;
    std::normal_distribution<double> gauss{0, sd};
    const auto noise = [&] { return std::complex<double>{gauss(rng), gauss(rng)}; };
    double sum = 0, squares = 0;
    constexpr int draws = 400;
    for (int i = 0; i < draws; ++i) {
        const double s = of({10.0 + noise(), 0.5 + noise(), 0.3 + noise()}, {1, 0, 0}).share.value;
        sum += s;
        squares += s * s;
    }
    const double mean = sum / draws, spread = std::sqrt(squares / draws - mean * mean);
    EXPECT_EQ(of({10, 0.5, 0.3}, {1, 0, 0}, sd).amplitude.sigma, sd);
    EXPECT_NEAR(spread / of({10, 0.5, 0.3}, {1, 0, 0}, sd).share.sigma, 1, 0.15);
}

}  // namespace
}  // namespace shaker::calibration
