#include "daemon/control/identification.hpp"

#include <gtest/gtest.h>

#include <random>

#include "daemon/control/equaliser.hpp"

namespace shaker::control {
namespace {

using Response = std::array<std::complex<double>, max_harmonics>;

Response sheet() {
    Response h;
    for (std::size_t k = 0; k < h.size(); ++k)
        h[k] = std::polar(60.0 + 5 * static_cast<double>(k), 0.8 - 0.1 * static_cast<double>(k));
    return h;
}

// Plays the requested drives to a plant until the identification is done.
template <class Plant>
IdentifiedResponse identify(const Plant& plant, double noise, double gamma = 9.8, int* windows = nullptr) {
    Identification id{{.gamma = gamma, .nominal = sheet()}};
    std::mt19937_64 rng{3};
    std::normal_distribution<double> gauss{0, noise};
    for (int k = 0; !id.done(); ++k) {
        PeriodEstimate w;
        for (int q = 1; q <= 8; ++q)
            w.along.at(q) = plant(q, id.volts()) + std::complex<double>{gauss(rng), gauss(rng)};
        id.take(w);
        if (windows != nullptr) *windows = k;
        if (k > 2000) ADD_FAILURE() << "never done";
        if (k > 2000) break;
    }
    return id.response();
}

TEST(IdentificationTest, MeasuresLinearResponseWithItsError) {
    Response truth = sheet();
    for (auto& h : truth) h *= std::polar(1.4, 0.5);
    const auto plant = [&](int q, const Harmonics<Voltage>& u) {
        return truth[static_cast<std::size_t>(q - 1)] * u.at(q);
    };
    const IdentifiedResponse r = identify(plant, 0.002);
    EXPECT_FALSE(r.nonlinear);
    EXPECT_FALSE(r.polarity_doubtful());
    EXPECT_NEAR(r.turn, 0.5, 0.01);
    for (std::size_t i = 0; i < 8; ++i) {
        EXPECT_LT(std::abs(r.h[i] - truth[i]), 5 * r.sd[i]);
        EXPECT_LT(r.sd[i], 0.01 * std::abs(truth[i]));
        EXPECT_GT(r.coherence[i], 0.99);
        EXPECT_NEAR(r.floor[i], 0.002 * std::sqrt(2), 0.001);
    }
    EXPECT_TRUE(findings(r).empty());
}

TEST(IdentificationTest, RaisesLevelsWhileBaseSticks) {
    const auto plant = [](int q, const Harmonics<Voltage>& u) {
        const double free = peak(u) > 0.05 ? 1 : 0.1;
        return free * sheet()[static_cast<std::size_t>(q - 1)] * u.at(q);
    };
    const IdentifiedResponse r = identify(plant, 1e-4);
    EXPECT_NEAR(std::abs(r.h[0] / sheet()[0]), 1, 0.01);
    EXPECT_FALSE(findings(r).empty() && r.nonlinear);
}

TEST(IdentificationTest, ReportsReversedPolarity) {
    const auto plant = [](int q, const Harmonics<Voltage>& u) {
        return -sheet()[static_cast<std::size_t>(q - 1)] * u.at(q);
    };
    const IdentifiedResponse r = identify(plant, 1e-4);
    EXPECT_TRUE(r.polarity_doubtful());
    EXPECT_FALSE(findings(r).empty());
}

TEST(IdentificationTest, OpenSensorLowersCoherence) {
    const auto plant = [](int, const Harmonics<Voltage>&) { return std::complex<double>{}; };
    const IdentifiedResponse r = identify(plant, 0.002);
    for (std::size_t i = 0; i < 8; ++i) EXPECT_LT(r.coherence[i], 0.6);
    EXPECT_GE(findings(r).size(), 8U);
}

TEST(IdentificationTest, StaysWithinQuarterOfTargetWhileRising) {
    double largest = 0;
    const auto plant = [&](int q, const Harmonics<Voltage>& u) {
        const std::complex<double> a = sheet()[static_cast<std::size_t>(q - 1)] * u.at(q);
        largest = std::max(largest, std::abs(a));
        return a;
    };
    identify(plant, 1e-4);
    EXPECT_LT(largest * 8, 0.8 * 9.8);
}

// A shaker that loses a fifth of its gain from level to level.
TEST(IdentificationTest, KeepsResponseOfEveryLevel) {
    double first_peak = 0;
    const auto plant = [&](int q, const Harmonics<Voltage>& u) {
        if (first_peak == 0) first_peak = peak(u);
        const double gain = std::pow(0.8, std::log(peak(u) / first_peak) / std::log(3.0));
        return gain * sheet()[static_cast<std::size_t>(q - 1)] * u.at(q);
    };
    const IdentifiedResponse r = identify(plant, 1e-4);
    ASSERT_GE(r.levels.size(), 2U);
    for (std::size_t k = 0; k < r.levels.size(); ++k) {
        const IdentifiedLevel& level = r.levels[k];
        EXPECT_NEAR(level.peak_V / r.levels[0].peak_V, std::pow(3.0, k), 1e-9);
        EXPECT_NEAR(std::abs(level.h[0] / sheet()[0]), std::pow(0.8, k), 0.01);
        EXPECT_GT(level.sd[0], 0);
    }
    EXPECT_EQ(r.levels.back().h, r.h);
    EXPECT_EQ(r.levels.back().peak_mps2, r.level);
}

// Each window finds its own axis, so the same motion has different components across it.
TEST(IdentificationTest, TransverseMotionIgnoresScatterOfTheAxis) {
    Identification id{{.nominal = sheet()}};
    std::mt19937_64 rng{3};
    std::normal_distribution<double> gauss{0, 1e-4};
    while (!id.done()) {
        PeriodEstimate w;
        w.axis = {std::cos(gauss(rng)), gauss(rng), 0};  // either y or z may be the smaller one
        (std::abs(gauss(rng)) < 7e-5 ? w.axis[2] : w.axis[1]) = gauss(rng);
        const auto across = calibration::across_axes(w.axis);
        for (int q = 1; q <= 8; ++q) {
            const std::complex<double> x = sheet()[static_cast<std::size_t>(q - 1)] * id.volts().at(q);
            const std::array<std::complex<double>, 3> a{x, 0.0, x * std::complex<double>{0, 0.03}};
            for (std::size_t k = 0; k < 3; ++k) {
                w.along.at(q) += w.axis[k] * a[k];
                for (std::size_t to = 0; to < 2; ++to) w.across[to].at(q) += across[to][k] * a[k];
            }
        }
        id.take(w);
    }
    for (std::size_t i = 0; i < 8; ++i) {
        const calibration::Transverse& t = id.response().across[i];
        EXPECT_NEAR(t.share.value, 0.03, 1e-3);
        EXPECT_NEAR(t.quadrature, 0.03, 1e-3);
        EXPECT_NEAR(t.direction[2], 1, 0.01);
    }
    EXPECT_NEAR(id.response().axis[0], 1, 1e-6);
}

}  // namespace
}  // namespace shaker::control
