#include "daemon/control/equaliser.hpp"

#include <gtest/gtest.h>

#include <deque>
#include <random>

#include "drivers/errors.hpp"

namespace shaker {
namespace {

/// A shaker period by period: complex response, delay of whole periods, a lag, a third harmonic that grows
/// with the cube of the first, noise.
class Plant {
public:
    std::array<std::complex<double>, max_harmonics> response{};
    double lag_turns = 0;
    double cubic = 0;  // third harmonic per first at 10 m/s^2
    double noise = 0;  // m/s^2, each component

    explicit Plant(int delay) : late_(static_cast<std::size_t>(delay)) {}
    HarmonicEstimate respond(const Harmonics<Voltage>& drive) {
        late_.push_back(drive);
        const Harmonics<Voltage> now = late_.front();
        late_.pop_front();
        std::normal_distribution<double> normal(0, 1);
        HarmonicEstimate e;
        e.valid = true;
        for (int q = 1; q <= 8; ++q) {
            const auto i = static_cast<std::size_t>(q - 1);
            truth.at(q) = response[i] * now.at(q);
            if (q == 3) truth.at(3) += cubic * truth.at(1) * std::pow(std::abs(truth.at(1)) / 10, 2);
            e.harmonics.at(q) = truth.at(q) * std::polar(1.0, -two_pi * q * lag_turns) +
                                noise * std::complex<double>(normal(random_), normal(random_));
            e.sd[i] = noise;
        }
        return e;
    }
    Harmonics<Acceleration> truth;

private:
    std::deque<Harmonics<Voltage>> late_;
    std::mt19937_64 random_{11};
};

constexpr double gamma_asked = 14.7;
Harmonics<Acceleration> target() { return harmonics(Drive{20, gamma_asked, 0.5, 0.6}); }

EqualiserSettings settings(int delay) {
    EqualiserSettings s;
    for (int q = 1; q <= 8; ++q) s.response[static_cast<std::size_t>(q - 1)] = std::polar(40.0 / q, -0.3 * q);
    s.delay_periods = delay;
    s.mu = Equaliser::largest_gain(delay);
    return s;
}

/// Response errors of 30 % in size and up to 0.3 rad that are no lag.
Plant plant(const EqualiserSettings& s, int delay) {
    Plant p(delay);
    for (std::size_t i = 0; i < 8; ++i) {
        p.response[i] =
            s.response[i] * std::polar(i % 2 == 0 ? 1.3 : 0.7, 0.1 * static_cast<double>(i % 4) - 0.1);
    }
    p.cubic = 0.05;
    return p;
}

void run(Equaliser& e, Plant& p, int periods) {
    for (int i = 0; i < periods; ++i) e.update(p.respond(e.drive()));
}

class DelayTest : public ::testing::TestWithParam<int> {};

TEST_P(DelayTest, ReachesTheTargetWithTheWrongResponseAndNoise) {
    const int delay = GetParam();
    const EqualiserSettings s = settings(delay);
    Equaliser e(s);
    Plant p = plant(s, delay);
    p.noise = 1e-3;
    e.set_target(target());
    run(e, p, 400);
    const Drive reached = drive_of(p.truth, 20);
    EXPECT_TRUE(e.report().locked);
    EXPECT_NEAR(reached.gamma, gamma_asked, 1e-3 * gamma_asked);
    EXPECT_NEAR(reached.phi, 0.6, 1e-3);
    EXPECT_LT(std::abs(p.truth.at(3)), 1e-3 * gamma_asked);  // -60 dB
    EXPECT_EQ(e.report().scale, 1);
}

INSTANTIATE_TEST_SUITE_P(Periods, DelayTest, ::testing::Values(0, 1, 2, 4));

TEST(EqualiserTest, AConstantLagChangesNothing) {
    const EqualiserSettings s = settings(1);
    for (const double lag : {0.0, 0.1, 0.37, -0.45}) {
        Equaliser e(s);
        Plant p = plant(s, 1);
        p.lag_turns = lag;
        e.set_target(target());
        run(e, p, 300);
        const Drive reached = drive_of(p.truth, 20);
        EXPECT_TRUE(e.report().locked) << lag;
        EXPECT_NEAR(reached.phi, 0.6, 1e-4) << lag;
        EXPECT_NEAR(reached.gamma, gamma_asked, 1e-4 * gamma_asked) << lag;
    }
}

TEST(EqualiserTest, GainsBeyondTheLimitOfTheDelayAreRefused) {
    for (const int delay : {0, 1, 2, 4}) {
        EqualiserSettings s = settings(delay);
        s.mu = 1.01 * Equaliser::largest_gain(delay);
        EXPECT_THROW(Equaliser{s}, InputError) << delay;
    }
}

TEST(EqualiserTest, InvalidMeasurementsNeverRaiseTheDrive) {
    const EqualiserSettings s = settings(1);
    Equaliser e(s);
    Plant p = plant(s, 1);
    e.set_target(target());
    run(e, p, 5);  // still far below the target
    const Harmonics<Voltage> before = e.drive();
    HarmonicEstimate invalid = p.respond(before), dead;
    invalid.valid = false;
    dead.valid = true;  // a sensor that fell off: valid zeros
    HarmonicEstimate broken = p.respond(before);
    broken.harmonics.at(2) = std::nan("");
    for (int i = 0; i < 50; ++i) {
        e.update(invalid);
        e.update(dead);
        e.update(broken);
    }
    EXPECT_EQ(e.drive(), before);
    EXPECT_EQ(e.report().ignored, 150);
    EXPECT_FALSE(e.report().locked);
}

TEST(EqualiserTest, AVoltageLimitKeepsTheShapeAndReportsTheReducedGamma) {
    EqualiserSettings s = settings(1);
    s.limit_V = 0.25;
    Equaliser e(s);
    Plant p = plant(s, 1);
    e.set_target(target());
    double most = 0;
    for (int i = 0; i < 600; ++i) {
        e.update(p.respond(e.drive()));
        for (int k = 0; k < 256; ++k) most = std::max(most, std::abs(value_at(e.drive(), two_pi * k / 256)));
    }
    EXPECT_LE(most, 0.25 * (1 + 1e-12));
    EXPECT_LT(e.report().scale, 0.9);
    const Drive reached = drive_of(p.truth, 20);
    EXPECT_NEAR(reached.gamma, e.report().gamma, 0.02 * e.report().gamma);  // the scale breathes by 2 % steps
    EXPECT_NEAR(reached.rho, 0.5, 0.01);
    EXPECT_NEAR(reached.phi, 0.6, 0.02);
}

TEST(EqualiserTest, StepsAreLimitedHoweverWrongTheResponse) {
    EqualiserSettings s = settings(1);
    Equaliser e(s);
    Plant p(1);
    for (std::size_t i = 0; i < 8; ++i) p.response[i] = s.response[i] / 5.0;
    e.set_target(target());
    const auto size = [](const Harmonics<Voltage>& u) {
        double sum = 0;
        for (const auto& a : u.a) sum += std::norm(a);
        return std::sqrt(sum);
    };
    for (int i = 0; i < 100; ++i) {
        const Harmonics<Voltage> before = e.drive();
        const Harmonics<Voltage> after = e.update(p.respond(before));
        EXPECT_LE(size(after), size(before) * (1 + s.step + 1e-12));
    }
}

TEST(EqualiserTest, AHarmonicThatIsDrivenAwayIsPutBackAndHeld) {
    const EqualiserSettings s = settings(1);
    Equaliser e(s);
    Plant p = plant(s, 1);
    p.response[4] = -s.response[4];  // the fifth answers with the wrong sign
    p.noise = 1e-3;
    e.set_target(target());
    run(e, p, 600);
    EXPECT_TRUE(e.report().held[4]);
    EXPECT_FALSE(e.report().held[0] || e.report().held[1] || e.report().held[2]);
    // It had no residual but noise to begin with; what is left is what the best of it was.
    EXPECT_LT(std::abs(p.truth.at(5)), 0.02 * gamma_asked);
    EXPECT_NEAR(drive_of(p.truth, 20).gamma, gamma_asked, 2e-3 * gamma_asked);
}

TEST(EqualiserTest, ANewTargetIsFollowedAndSilenceIsSilent) {
    const EqualiserSettings s = settings(1);
    Equaliser e(s);
    Plant p = plant(s, 1);
    e.set_target(target());
    run(e, p, 300);
    e.set_target(harmonics(Drive{20, 9.8, 0.5, -1.2}));
    run(e, p, 300);
    EXPECT_NEAR(drive_of(p.truth, 20).phi, -1.2, 1e-3);
    EXPECT_NEAR(drive_of(p.truth, 20).gamma, 9.8, 1e-2);
    e.set_target({});
    EXPECT_EQ(e.drive(), Harmonics<Voltage>{});
}

TEST(EqualiserTest, ATargetOfOneHarmonicAlsoLocks) {
    for (const double rho : {0.0, 1.0}) {
        const EqualiserSettings s = settings(1);
        Equaliser e(s);
        Plant p = plant(s, 1);
        p.lag_turns = 0.2;
        e.set_target(harmonics(Drive{20, 9.8, rho, 0.4}));
        run(e, p, 400);
        EXPECT_NEAR(std::abs(p.truth.at(rho > 0 ? 1 : 2)), 9.8, 0.01) << rho;
        EXPECT_LT(e.report().residual_db[rho > 0 ? 1 : 0], -60) << rho;
    }
}

TEST(EqualiserTest, SettingsOutOfRangeAreNamed) {
    EqualiserSettings s = settings(1);
    s.response[2] = 0;
    try {
        Equaliser e(s);
        FAIL() << "a response of 0 cannot be inverted";
    } catch (const InputError& e) {
        EXPECT_NE(std::string(e.what()).find("response of harmonic 3"), std::string::npos) << e.what();
    }
}

}  // namespace
}  // namespace shaker
