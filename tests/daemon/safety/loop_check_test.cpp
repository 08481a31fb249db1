#include "daemon/safety/loop_check.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "daemon/control/equaliser.hpp"

namespace shaker::safety {
namespace {

// 20 m/s^2 per V at f, 25 at 2f.
LoopCheckPlan plan() {
    LoopCheckPlan p{.target = harmonics(Drive{.frequency = 20, .gamma = paper_g, .rho = 0.5, .phi = 0})};
    p.response.fill(20);
    p.response[1] = 25;
    p.noise = 1e-3;
    return p;
}

control::IdentifiedResponse identified(const LoopCheckPlan& p) {
    control::IdentifiedResponse r;
    r.h = p.response;
    r.levels = {{.peak_V = 0.02, .h = p.response}, {.peak_V = 0.06, .h = p.response}};
    return r;
}

// The bench answers with `gain` times the response in use, and with this noise.
LoopCheck checked(const LoopCheckPlan& p, std::complex<double> gain, double noise) {
    LoopCheck check{p};
    std::mt19937 random{1};
    std::normal_distribution<double> part{0, noise};
    bool done = false;
    for (int n = 1; !done; ++n) {
        Harmonics<Acceleration> y;
        for (std::size_t q = 0; q < max_harmonics; ++q)
            y.a[q] =
                gain * p.response[q] * check.volts().a[q] + std::complex<double>{part(random), part(random)};
        done = check.take(y, 1);
        EXPECT_EQ(done, n == LoopCheck::periods);
    }
    return check;
}

double peak_of(const LoopCheckPlan& p, const LoopCheck& check) {
    Harmonics<Acceleration> y;
    for (std::size_t q = 0; q < max_harmonics; ++q) y.a[q] = p.response[q] * check.volts().a[q];
    double peak = 0;
    for (int i = 0; i < 512; ++i) peak = std::max(peak, std::abs(value_at(y, two_pi * i / 512)));
    return peak;
}

double full_peak(const LoopCheckPlan& p) {
    double peak = 0;
    for (int i = 0; i < 512; ++i) peak = std::max(peak, std::abs(value_at(p.target, two_pi * i / 512)));
    return peak;
}

// Without gravity and a camera that sees the base, the response in use is all that shows the gain.
TEST(LoopCheckTest, AGainThatNothingElseShowsIsHeldTighter) {
    LoopCheckPlan p = plan();
    const control::IdentifiedResponse known = identified(p);
    for (const bool has_response : {false, true}) {
        p.identified = has_response ? &known : nullptr;
        for (const double gain : {0.75, 1.3}) {
            p.gain_shown = true;
            EXPECT_FALSE(checked(p, gain, 1e-4).trip()) << gain;
            p.gain_shown = false;
            ASSERT_TRUE(checked(p, gain, 1e-4).trip()) << gain;
            EXPECT_EQ(checked(p, gain, 1e-4).trip()->cause, Cause::gain_limit);
        }
        EXPECT_FALSE(checked(p, 0.85, 1e-4).trip());
        EXPECT_FALSE(checked(p, 1.2, 1e-4).trip());
    }
}

TEST(LoopCheckTest, LevelIsFivePercentOfTheDrive) {
    const LoopCheckPlan p = plan();
    EXPECT_NEAR(peak_of(p, LoopCheck{p}), 0.05 * full_peak(p), 1e-9);
}

TEST(LoopCheckTest, LevelIsTenTimesTheNoise) {
    LoopCheckPlan p = plan();
    p.noise = 0.045;
    EXPECT_NEAR(peak_of(p, LoopCheck{p}), 0.45, 1e-9);
}

TEST(LoopCheckTest, LevelIsBelowTheWalkersThreshold) {
    LoopCheckPlan p = plan();
    for (auto& a : p.target.a) a *= 10;
    EXPECT_NEAR(peak_of(p, LoopCheck{p}), 0.5, 1e-9);
    p.noise = 1;
    EXPECT_NEAR(peak_of(p, LoopCheck{p}), 0.5, 1e-9);
}

TEST(LoopCheckTest, SmallDriveIsNotExceeded) {
    LoopCheckPlan p = plan();
    for (auto& a : p.target.a) a *= 1e-3;
    p.noise = 1;
    EXPECT_NEAR(peak_of(p, LoopCheck{p}), full_peak(p), 1e-9);
}

TEST(LoopCheckTest, StickingBaseIsCheckedWhereItIsFree) {
    LoopCheckPlan p = plan();
    control::IdentifiedResponse r = identified(p);
    for (auto& h : r.levels[0].h) h *= 0.05;
    p.identified = &r;
    const LoopCheck check = checked(p, 1, 1e-3);
    EXPECT_NEAR(control::peak(check.volts()), 0.06, 1e-9);
    EXPECT_FALSE(check.trip()) << check.finding();
}

TEST(LoopCheckTest, AgreementStartsTheDrive) {
    LoopCheckPlan p = plan();
    const control::IdentifiedResponse r = identified(p);
    p.identified = &r;
    for (const double gain : {0.65, 1.0, 1.5}) {
        const LoopCheck check = checked(p, std::polar(gain, 0.5), 1e-3);
        EXPECT_FALSE(check.trip()) << check.finding();
    }
}

TEST(LoopCheckTest, WrongGainIsNamed) {
    LoopCheckPlan p = plan();
    const control::IdentifiedResponse r = identified(p);
    p.identified = &r;
    for (const double gain : {0.1, 0.5, 1.7, 10.0}) {
        const LoopCheck check = checked(p, gain, 1e-3);
        ASSERT_TRUE(check.trip());
        EXPECT_EQ(check.trip()->cause, Cause::gain_limit);
        EXPECT_NEAR(check.trip()->value, gain, 0.01);
        EXPECT_NE(check.finding().find("loop check: gain"), std::string::npos) << check.finding();
    }
}

TEST(LoopCheckTest, DataSheetMayBeWrongByAFactorOfFour) {
    const LoopCheckPlan p = plan();
    EXPECT_FALSE(checked(p, 0.3, 1e-3).trip());
    EXPECT_FALSE(checked(p, 3.9, 1e-3).trip());
    EXPECT_TRUE(checked(p, 0.2, 1e-3).trip());
    EXPECT_TRUE(checked(p, 4.2, 1e-3).trip());
}

TEST(LoopCheckTest, WrongPolarityIsNamed) {
    LoopCheckPlan p = plan();
    const LoopCheck check = checked(p, -1, 1e-3);
    ASSERT_TRUE(check.trip());
    EXPECT_EQ(check.trip()->cause, Cause::polarity);
    EXPECT_NE(check.finding().find("loop check: polarity"), std::string::npos) << check.finding();
    p.direction_known = false;
    EXPECT_FALSE(checked(p, -1, 1e-3).trip());
}

TEST(LoopCheckTest, NoiseIsNamed) {
    const LoopCheckPlan p = plan();
    for (const LoopCheck& check : {checked(p, 0, 1e-3), checked(p, 1, 1)}) {
        ASSERT_TRUE(check.trip());
        EXPECT_EQ(check.trip()->cause, Cause::sensor_open);
        EXPECT_NE(check.finding().find("loop check: noise"), std::string::npos) << check.finding();
    }
}

}  // namespace
}  // namespace shaker::safety
