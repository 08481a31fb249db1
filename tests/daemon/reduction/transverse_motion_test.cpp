// Motion across the shaker's axis in the results of a complete reduction.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "daemon/reduction/reduction.hpp"
#include "tests/support/run/synthetic_run.hpp"

namespace shaker::reduction {
namespace {

const SyntheticRun bench{.third = 0.5};

// The bench, with `share` of harmonic 2 on the sensor's z besides, a quarter period off.
Measurement rocking(double share) {
    Measurement m = make_measurement(bench);
    const double amplitude = share * bench.drive.gamma * (1 - bench.drive.rho);
    for (std::size_t i = 0; i < m.accelerometer.t_s.size(); ++i) {
        const double t = m.accelerometer.t_s[i] * (1 + 1e-6 * bench.ppm) - bench.late_s;
        m.accelerometer.a_mps2[i][2] +=
            amplitude * std::cos(2 * two_pi * bench.drive.frequency * t + bench.drive.phi);
    }
    return m;
}

TEST(AcrossTest, MotionAlongTheAxisGivesNoiseOnly) {
    Measurement m = make_measurement(bench);
    m.accelerometer.shaker_axis = bench.axis;
    const Reduction r = reduce(m);
    for (const MeasuredHarmonic& h : r.harmonics) {
        if (h.q > 3) continue;
        EXPECT_GT(h.across.share.sigma, 0);
        // Four parts of noise: beyond 5 sigma once in 10^4.
        EXPECT_LT(h.across.share.value, 5 * h.across.share.sigma) << h.q;
        EXPECT_LT(h.across.share.sigma, 1e-3) << h.q;
    }
}

// An axis that the sensor does not have is not an axis without motion, and no gravity is not a level base.
TEST(AcrossTest, WhatASensorWithFewerAxesDoesNotMeasureIsNotKnown) {
    for (const int axes : {1, 2}) {
        Measurement m = make_measurement(bench);
        m.accelerometer.axes = axes;
        m.accelerometer.gravity = false;
        m.accelerometer.shaker_axis = {1, 0, 0};
        for (auto& a : m.accelerometer.a_mps2)
            for (std::size_t k = static_cast<std::size_t>(axes); k < 3; ++k) a[k] = 0;
        const Reduction r = reduce(m);
        for (const MeasuredHarmonic& h : r.harmonics) {
            EXPECT_TRUE(std::isnan(h.across.share.value)) << axes << " axes, harmonic " << h.q;
            EXPECT_TRUE(std::isnan(h.across.amplitude.value));
            EXPECT_TRUE(std::isnan(h.across.in_phase));
        }
        EXPECT_TRUE(std::isnan(r.tilt.angle.value));
        EXPECT_FALSE(r.degraded);
        const auto said = [&](const char* words) {
            return std::ranges::any_of(r.notes, [&](const std::string& n) { return n.find(words) == 0; });
        };
        EXPECT_TRUE(said("motion across the shaker's axis is not known"));
        EXPECT_TRUE(said("tilt by gravity is not known"));
        EXPECT_TRUE(doubts_of(r).empty());
        EXPECT_NEAR(r.v_D.value, reduce(make_measurement(bench)).v_D.value, r.v_D.sigma);
    }
}

TEST(AcrossTest, TurnedSensorIsInPhaseAtEveryHarmonic) {
    Measurement m = make_measurement(bench);
    m.accelerometer.shaker_axis = {1, 0, 0};  // it is turned by 2 degrees
    const Reduction r = reduce(m);
    for (const MeasuredHarmonic& h : r.harmonics) {
        if (h.q > 3) continue;
        EXPECT_NEAR(h.across.share.value, std::tan(2 * std::numbers::pi / 180), 5 * h.across.share.sigma);
        EXPECT_NEAR(h.across.in_phase, h.across.share.value, 1e-3);
        EXPECT_LT(h.across.quadrature, 5 * h.across.share.sigma);
        EXPECT_NEAR(h.across.direction[1], 1, 0.02);
    }
}

TEST(AcrossTest, RockingIsInQuadratureAtItsHarmonicAlone) {
    Measurement m = rocking(0.02);
    m.accelerometer.shaker_axis = bench.axis;
    const Reduction r = reduce(m);
    const calibration::Transverse &first = r.harmonics[0].across, &second = r.harmonics[1].across;
    EXPECT_LT(first.share.value, 5 * first.share.sigma);
    EXPECT_NEAR(second.share.value, 0.02, 5 * second.share.sigma);
    // A share of 2 % is known to better than its hundredth.
    EXPECT_LT(second.share.sigma, 2e-4);
    EXPECT_NEAR(second.quadrature, 0.02, 5 * second.share.sigma);
    EXPECT_LT(second.in_phase, 0.002);
    EXPECT_NEAR(second.direction[2], 1, 1e-3);
}

}  // namespace
}  // namespace shaker::reduction
