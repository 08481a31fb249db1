#include "calibration/harmonics/harmonic_sums.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <random>

#include "calibration/harmonics/phasors.hpp"
#include "drivers/drive.hpp"

namespace shaker::calibration {
namespace {

constexpr double f = 20, origin = 3.5;

struct Stream {
    std::vector<double> t, y, sd;
    [[nodiscard]] HarmonicSamples samples() const { return {t, y, sd}; }
};

/// Irregular times with a gap, a length that is not a whole number of blocks, different weights.
Stream rough(unsigned seed, double constant) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> step(0.2e-3, 1.8e-3), sd(0.5, 2);
    Stream s;
    for (double t = 3; t < 4.1; t += step(random)) {
        if (t > 3.4 && t < 3.52) continue;
        s.t.push_back(t);
        s.sd.push_back(0.01 * sd(random));
        s.y.push_back(constant + 2 * t + std::sin(two_pi * f * t) + 0.3 * std::cos(2 * two_pi * f * t) +
                      s.sd.back() * normal(random));
    }
    return s;
}

/// Textbook least squares in long double: all rows are stored and summed directly.
struct Plain {
    using Matrix = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;
    Matrix inverse, p;
    long double chi2 = 0;
    long double freedom = 0;

    Plain(const std::vector<Stream>& streams, const std::vector<double>& scale, int order) {
        const int n = 2 * order + 1 + static_cast<int>(streams.size());
        Matrix normal = Matrix::Zero(n, n), right = Matrix::Zero(n, 1);
        const auto rows = [&](auto&& use) {
            for (std::size_t k = 0; k < streams.size(); ++k) {
                for (std::size_t i = 0; i < streams[k].t.size(); ++i) {
                    Matrix row = Matrix::Zero(n, 1);
                    const long double dt = static_cast<long double>(streams[k].t[i]) - origin;
                    for (int q = 1; q <= order; ++q) {
                        const long double angle = 2 * std::numbers::pi_v<long double> * f * q * dt;
                        const Eigen::Index sine = 2L * (q - 1);
                        row(sine, 0) = std::sin(angle);
                        row(sine + 1, 0) = std::cos(angle);
                    }
                    row(2L * order, 0) = dt;
                    row(2L * order + 1 + static_cast<int>(k), 0) = 1;
                    const long double sd = static_cast<long double>(streams[k].sd[i]) * scale[k];
                    use(Matrix(row / sd), streams[k].y[i] / sd);
                }
            }
        };
        rows([&](const Matrix& row, long double y) {
            normal += row * row.transpose();
            right += y * row;
            ++freedom;
        });
        inverse = normal.ldlt().solve(Matrix::Identity(n, n));
        p = normal.ldlt().solve(right);
        freedom -= n;
        rows([&](const Matrix& row, long double y) {
            const long double r = y - (row.transpose() * p)(0, 0);
            chi2 += r * r;
        });
    }
};

class AgainstPlainSums : public ::testing::TestWithParam<std::pair<int, int>> {};

/// Amplitudes, slope, constants, their covariance and the residual agree to 1e-12 of the largest.
TEST_P(AgainstPlainSums, EveryFitEqualsPlainSums) {
    const auto [gathered, order] = GetParam();
    const std::vector<Stream> streams{rough(1, 5), rough(2, -40)};
    const std::array<HarmonicSamples, 2> in{streams[0].samples(), streams[1].samples()};
    const HarmonicSums sums(in, f, gathered, Slope::free);
    for (const std::vector<double>& scale : {std::vector<double>{1, 1}, std::vector<double>{0.7, 3.1}}) {
        const HarmonicFit fit = sums.fit(order, scale);
        const Plain plain(streams, scale, order);
        const auto variance = static_cast<double>(plain.chi2 / plain.freedom);
        EXPECT_NEAR(fit.scale * fit.scale / variance, 1, 1e-12);
        EXPECT_NEAR(fit.slope.value, static_cast<double>(plain.p(2L * order, 0)), 2e-12);
        for (int k = 0; k < 2; ++k) {
            const double constant =
                fit.constants[static_cast<std::size_t>(k)] - fit.slope.value * (fit.origin_s - origin);
            EXPECT_NEAR(constant, static_cast<double>(plain.p(2 * order + 1 + k, 0)), 40e-12);
        }
        for (int q = 1; q <= order; ++q) {
            const int i = 2 * (q - 1);
            const std::complex<double> truth(static_cast<double>(plain.p(i, 0)),
                                             static_cast<double>(plain.p(i + 1, 0)));
            const auto turn = std::polar(1.0, two_pi * f * q * (fit.origin_s - origin));
            EXPECT_LT(std::abs(fit.at(q) - truth * turn), 1e-12) << q;
            // The trace over a harmonic's two components is independent of the origin.
            const double trace =
                variance * static_cast<double>(plain.inverse(i, i) + plain.inverse(i + 1, i + 1));
            EXPECT_NEAR((fit.cov(i, i) + fit.cov(i + 1, i + 1)) / trace, 1, 1e-12) << q;
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Orders, AgainstPlainSums,
                         ::testing::Values(std::pair{1, 1}, std::pair{4, 4}, std::pair{12, 12},
                                           std::pair{12, 5}));

TEST(HarmonicSumsTest, OneOfSeveralStreamsFitsLikeAlone) {
    const std::vector<Stream> streams{rough(1, 5), rough(2, -40)};
    const std::array<HarmonicSamples, 2> in{streams[0].samples(), streams[1].samples()};
    const HarmonicFit one = HarmonicSums(in, f, 6, Slope::free).of_stream(1).fit(6);
    const HarmonicFit alone = fit_harmonics({&in[1], 1}, f, 6, Slope::free);
    EXPECT_NEAR(one.slope.value, alone.slope.value, 2e-12);
    EXPECT_NEAR(one.slope.sigma / alone.slope.sigma, 1, 1e-12);
    EXPECT_EQ(one.samples, streams[1].t.size());
    for (int q = 1; q <= 6; ++q) EXPECT_LT(std::abs(one.at(q) - alone.at(q)), 1e-12);
}

TEST(HarmonicSumsTest, SignalsAtTheSameTimesFitLikeEachAlone) {
    const Stream a = rough(1, 5);
    std::vector<double> b;
    for (const double y : a.y) b.push_back(3 - y * y);
    const std::array<std::span<const double>, 2> both{a.y, b};
    const std::vector<HarmonicFit> fits = fit_signals(a.t, both, f, 4);
    for (std::size_t s = 0; s < 2; ++s) {
        const HarmonicSamples in{a.t, both[s], {}};
        const HarmonicFit alone = fit_harmonics({&in, 1}, f, 4, Slope::none);
        EXPECT_NEAR(fits[s].rms / alone.rms, 1, 1e-12);
        for (int q = 1; q <= 4; ++q) EXPECT_LT(std::abs(fits[s].at(q) - alone.at(q)), 1e-12 * alone.rms);
    }
}

TEST(PhasorTest, StaysExactAfterAnHour) {
    std::mt19937_64 random(7);
    std::uniform_real_distribution<double> near(-1, 1), far(-72000, 72000);
    for (int repeat = 0; repeat < 200; ++repeat) {
        std::array<double, Phasors::size> turns{};
        for (double& x : turns) x = repeat % 2 == 0 ? near(random) : far(random);
        const Phasors z = phasors(turns);
        for (std::size_t i = 0; i < turns.size(); ++i) {
            const long double angle = 2 * std::numbers::pi_v<long double> *
                                      std::remainder(static_cast<long double>(turns[i]), 1.0L);
            EXPECT_NEAR(z.re[i], static_cast<double>(std::cos(angle)), 2e-15);
            EXPECT_NEAR(z.im[i], static_cast<double>(std::sin(angle)), 2e-15);
        }
    }
}

TEST(PhasorTest, PeriodicPartAtManyTimesEqualsSingleTimes) {
    const Stream s = rough(3, 1);
    const HarmonicSamples in = s.samples();
    const HarmonicFit fit = fit_harmonics({&in, 1}, f, 12, Slope::free);
    std::vector<double> many(s.t.size());
    fit.periodic(s.t, many);
    for (std::size_t i = 0; i < many.size(); ++i) EXPECT_NEAR(many[i], fit.periodic(s.t[i]), 1e-13);
}

}  // namespace
}  // namespace shaker::calibration
