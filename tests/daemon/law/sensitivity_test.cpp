#include "daemon/law/sensitivity.hpp"

#include <gtest/gtest.h>

#include "tests/support/law/synthetic_points.hpp"

namespace shaker::law {
namespace {

constexpr Coulomb tilted{.mu = 0.113, .tilt = 1e-3, .push = 0.1077};

// Every derivative against a central difference; two slips, three and four events, with and without stick.
TEST(SensitivityTest, DerivativesAreDifferences) {
    for (const auto& [gamma, phi] : {std::pair{1.0, 0.0}, {0.5, 0.0}, {2.0, 1.57}, {1.0, 2.2}, {3.0, 4.0}}) {
        const Harmonics<Acceleration> base = harmonics(test::drive_at(gamma, phi));
        const PushedCycle cycle = pushed_cycle(base, 20, tilted);
        const Sensitivity by{cycle, 20, tilted};
        const auto expect = [&](const Change& change, double step) {
            const auto moved = [&](double by_how_much) {
                Coulomb law = tilted;
                law.mu += by_how_much * change.mu;
                law.tilt += by_how_much * change.tilt;
                law.push += by_how_much * change.push;
                law.g += by_how_much * change.gravity;
                Harmonics<Acceleration> b = base;
                for (std::size_t i = 0; i < max_harmonics; ++i) b.a[i] += by_how_much * change.base.a[i];
                return pushed_cycle(b, 20, law, &cycle).v_D;
            };
            const double difference = (moved(step) - moved(-step)) / (2 * step);
            EXPECT_NEAR(by(change), difference, 2e-3 * std::abs(difference) + 5e-6) << gamma << " g, " << phi;
        };
        expect({.mu = 1}, 1e-5);
        expect({.tilt = 1}, 1e-6);
        expect({.push = 1}, 1e-4);
        expect({.gravity = 1}, 1e-4);
        Change overtones;
        overtones.base.at(2) = {0.3, 0.5};
        overtones.base.at(3) = {-0.2, 1};
        expect(overtones, 1e-4);
    }
}

TEST(SensitivityTest, GradientOfTheBaseIsThatOfEachHarmonic) {
    Coulomb free = tilted;
    free.push = 0;  // the gradient leaves the change of the push out
    const PushedCycle cycle = pushed_cycle(harmonics(test::drive_at(1, 2.2)), 20, free);
    const Sensitivity by{cycle, 20, free};
    const Amplitudes gradient = by.by_base();
    for (int q = 1; q <= max_harmonics; ++q) {
        Change real, imaginary;
        real.base.at(q) = 1;
        imaginary.base.at(q) = {0, 1};
        EXPECT_NEAR(gradient[static_cast<std::size_t>(q - 1)].real(), by(real), 1e-12) << q;
        EXPECT_NEAR(gradient[static_cast<std::size_t>(q - 1)].imag(), by(imaginary), 1e-12) << q;
    }
}

TEST(SensitivityTest, WalkerAtRestDoesNotRespond) {
    const PushedCycle cycle = pushed_cycle(harmonics(test::drive_at(0.1, 0)), 20, tilted);
    const Sensitivity by{cycle, 20, tilted};
    EXPECT_EQ(by({.mu = 1}), 0);
    EXPECT_EQ(by.by_drag(), 0);
    EXPECT_EQ(by.by_base()[0], 0.0);
}

}  // namespace
}  // namespace shaker::law
