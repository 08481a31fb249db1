#include "daemon/safety/preflight.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "drivers/errors.hpp"

namespace shaker::safety {
namespace {

constexpr double w = two_pi * 20;

PlannedMotion motion(const Harmonics<Acceleration>& target) {
    PlannedMotion m{.target = target, .frequency = 20, .moving_kg = 0.5};
    for (std::size_t k = 0; k < m.response.size(); ++k)
        m.response[k] = std::polar(40.0, 0.1 * static_cast<double>(k));
    return m;
}

Limits generous() {
    Limits l;
    l.acceleration = l.velocity = l.displacement = l.drive = {1e9, 1e9};
    l.force_n = 1e9;
    return l;
}

double value(const std::vector<Demand>& all, const std::string& quantity) {
    for (const Demand& d : all)
        if (d.quantity == quantity) return d.value;
    ADD_FAILURE() << quantity;
    return 0;
}

TEST(EnvelopeTest, SineHasTextbookAmplitudes) {
    Harmonics<Acceleration> a;
    a.at(3) = std::polar(12.0, 0.4);
    const auto d = demands(motion(a), generous());
    EXPECT_NEAR(value(d, "acceleration"), 12, 1e-9);
    EXPECT_NEAR(value(d, "velocity"), 12 / (3 * w), 1e-12);
    EXPECT_NEAR(value(d, "displacement"), 12e3 / (9 * w * w), 1e-10);
    EXPECT_NEAR(value(d, "force"), 6, 1e-9);
    EXPECT_NEAR(value(d, "drive"), 0.3, 1e-12);
}

// sin + sin 2 is largest where cos + 2 cos 2 = 0, that is cos = (sqrt(33) - 1) / 8.
TEST(EnvelopeTest, UsesPeakOfSumNotSumOfPeaks) {
    const double c = (std::sqrt(33.0) - 1) / 8, s = std::sqrt(1 - c * c);
    const double in_phase = 0.5 * (s + 2 * s * c);  // gamma = 1, rho = 1/2, phi = 0
    const auto zero = demands(motion(harmonics(Drive{.gamma = 30})), generous());
    EXPECT_NEAR(value(zero, "acceleration"), 30 * in_phase, 1e-9);
    EXPECT_NEAR(in_phase, 0.88, 1e-3);
    // phi = pi/2: sin + cos 2 is largest in size, 2, where the sine is -1.
    const auto quarter = demands(motion(harmonics(Drive{.gamma = 30, .phi = two_pi / 4})), generous());
    EXPECT_NEAR(value(quarter, "acceleration"), 30, 1e-9);
    // Displacement -(sin + cos 2 / 4) / w^2 there: 1 + 1/4 at the same place.
    EXPECT_NEAR(value(quarter, "displacement"), 1e3 * 15 / (w * w) * 1.25, 1e-9);
    // Velocity cos - sin 2 / 2 has its extremes where sin + cos 2 = 0: sin = 1 or -1/2; there it is 3 sqrt(3)
    // / 4.
    EXPECT_NEAR(value(quarter, "velocity"), 15 / w * 0.75 * std::sqrt(3.0), 1e-12);
}

TEST(EnvelopeTest, RefusesExcessWithAllFigures) {
    Limits l = limits_of({.max_force_n = 20,
                          .moving_mass_kg = 0.1,
                          .load_kg = 0.4,
                          .stroke_m = 4e-3,
                          .sensor_range_mps2 = 78.5,
                          .full_scale_V = 1});
    const auto fits = demands(motion(harmonics(Drive{.gamma = 2 * paper_g})), l);
    EXPECT_NO_THROW(require_within(fits, 2 * paper_g));
    const auto all = demands(motion(harmonics(Drive{.gamma = 5 * paper_g})), l);
    try {
        require_within(all, 5 * paper_g);
        FAIL() << "accepted";
    } catch (const InputError& e) {
        const std::string said = e.what();
        for (const char* part : {"acceleration peak 43.1", "32 m/s^2", "displacement peak 1.7", "1.6 mm",
                                 "force peak 21.", "16 N", "drive peak 1."})
            EXPECT_NE(said.find(part), std::string::npos) << said;
        EXPECT_EQ(said.find("velocity"), std::string::npos) << said;
    }
}

TEST(EnvelopeTest, RefusesHarmonicWithUnknownResponse) {
    PlannedMotion m = motion(harmonics(Drive{}));
    m.response[1] = 0;
    EXPECT_THROW(demands(m, generous()), InputError);
    m.target.at(2) = 0;
    EXPECT_NO_THROW(demands(m, generous()));
}

TEST(EnvelopeTest, SilenceNeedsNothing) {
    for (const Demand& d : demands(motion({}), generous())) EXPECT_EQ(d.value, 0) << d.quantity;
}

}  // namespace
}  // namespace shaker::safety
