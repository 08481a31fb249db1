// v(t) of walkers under laws of friction, on drives drawn by a seed, against their exact motion.
#include "daemon/reduction/kinked_motion.hpp"

#include <gtest/gtest.h>
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/support/run/synthetic_run.hpp"
#include "tests/support/walker/walker_settings.hpp"

namespace shaker::reduction {
namespace {

struct Law {
    friend void PrintTo(const Law& l, std::ostream* out) { *out << l.name; }
    const char* name;
    walker::Friction friction;
};

SyntheticRun scene(const Law& law, double rate, std::uint64_t seed) {
    std::mt19937_64 random{seed};
    SyntheticRun run;
    run.friction = law.friction;
    run.drive = {20, uniform(random, 0.4, 3) * paper_g, 0.5, uniform(random, 0, two_pi)};
    run.frame_rate_hz = rate;
    run.exposure_s = 3e-4;
    run.seed = seed;
    return run;
}

double near(const Reduction& r, double phase) {
    double least = 1;
    const auto see = [&](double at) { least = std::min(least, std::abs(std::remainder(phase - at, 1.0))); };
    for (const Flip& f : r.flips) see(f.at);
    for (const StickInterval& s : r.stick) {
        see(s.from);
        see(s.to);
    }
    return least;
}

struct Count {
    int n = 0, covered = 0;
    double squares = 0, variances = 0;
    void add(const calibration::Estimate& v, double truth) {
        const double e = v.value - truth;
        ++n;
        covered += std::abs(e) < 2 * v.sigma;
        squares += e * e;
        variances += v.sigma * v.sigma;
    }
    [[nodiscard]] double share() const { return covered / static_cast<double>(n); }
    [[nodiscard]] double rms() const { return 1e3 * std::sqrt(squares / n); }
    [[nodiscard]] double sd() const { return 1e3 * std::sqrt(variances / n); }
};

class KinkedMotionTest : public ::testing::TestWithParam<Law> {};

TEST_P(KinkedMotionTest, CoversTheTruthAtKinksAndBetween) {
    for (const double rate : {1000.0, 500.0}) {
        Count kinks, between;
        constexpr int fine = 20000, scenes = 24;
        for (std::uint64_t seed = 1; seed <= scenes; ++seed) {
            const SyntheticRun run = scene(GetParam(), rate, seed);
            const auto v = true_velocity(run, fine);
            const Reduction r = reduce(make_measurement(run));
            for (std::size_t i = 0; i < r.cycle.phase.size(); ++i) {
                const auto k = static_cast<std::size_t>(r.cycle.phase[i] * fine + 0.5) % fine;
                (near(r, r.cycle.phase[i]) < 2.5 * 20 / rate ? kinks : between)
                    .add({r.cycle.v_mps[i], r.cycle.v_sd_mps[i]}, v[k]);
            }
        }
        const std::string found = fmt::format(
            "{:.0f} frames/s: at kinks {:.3f} of {}, rms {:.3f}, error {:.3f} mm/s; between {:.3f} of "
            "{}, rms {:.3f}, error {:.3f} mm/s",
            rate, kinks.share(), kinks.n, kinks.rms(), kinks.sd(), between.share(), between.n, between.rms(),
            between.sd());
        RecordProperty("covered", found);
        EXPECT_GT(kinks.share(), 0.92) << found;
        EXPECT_GT(between.share(), 0.90) << found;
        EXPECT_LT(kinks.rms(), 0.2) << found;
        EXPECT_LT(kinks.sd(), 0.2) << "an error that is always large covers everything: " << found;
        EXPECT_LT(between.sd(), 0.1) << found;
    }
}

// The end of a slip of Coulomb's walker has no duration, and lies where the exact walker turns round.
TEST(FlipTest, IsWhereTheWalkerTurnsAndShort) {
    int n = 0, covered = 0;
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        SyntheticRun run;
        run.drive = {20, paper_g, 0.5, 0};
        run.seed = seed;
        const Reduction r = reduce(make_measurement(run));
        for (const double at : {0.1922404374081, 0.6922404374081}) {
            const auto flip = std::ranges::find_if(
                r.flips, [&](const Flip& f) { return std::abs(std::remainder(f.at - at, 1.0)) < 0.02; });
            ASSERT_NE(flip, r.flips.end()) << "seed " << seed << ", at " << at;
            EXPECT_LT(flip->at_sd, 0.01);
            EXPECT_LT(flip->below_s, 3.5e-3);
            ++n;
            covered += std::abs(std::remainder(flip->at - at, 1.0)) < 2 * flip->at_sd;
        }
    }
    EXPECT_GE(covered, 35) << "of " << n;
}

// Where no picture shows a part of the period, the rest of v(t) is as known as before.
TEST(FlipTest, APartWithoutPicturesLeavesTheRestKnown) {
    SyntheticRun run;
    Measurement m = make_measurement(run);
    MotionSeries& walker = m.walkers[0];
    MotionSeries seen = walker;
    seen.t_s.clear();
    seen.x_m.clear();
    seen.sd_m.clear();
    for (std::size_t i = 0; i < walker.t_s.size(); ++i) {
        const double p = walker.t_s[i] * 20 - std::floor(walker.t_s[i] * 20);
        if (p > 0.3 && p < 0.5) continue;
        seen.t_s.push_back(walker.t_s[i]);
        seen.x_m.push_back(walker.x_m[i]);
        seen.sd_m.push_back(walker.sd_m[i]);
    }
    walker = seen;
    const Reduction r = reduce(m);
    for (std::size_t i = 0; i < r.cycle.phase.size(); ++i) {
        if (r.cycle.phase[i] > 0.25 && r.cycle.phase[i] < 0.55) continue;
        EXPECT_TRUE(std::isfinite(r.cycle.v_mps[i])) << r.cycle.phase[i];
        EXPECT_LT(r.cycle.v_sd_mps[i], 1e-3) << r.cycle.phase[i];
    }
}

walker::Friction with(auto change) {
    walker::Friction f;
    change(f);
    return f;
}

INSTANTIATE_TEST_SUITE_P(
    Laws, KinkedMotionTest,
    ::testing::Values(Law{"coulomb", {}}, Law{"viscous", with([](auto& f) { f.viscous = 3.5; })},
                      Law{"dahl", with([](auto& f) { f.law = walker::FrictionLaw::dahl; })},
                      Law{"stribeck", with([](auto& f) {
                              f.law = walker::FrictionLaw::stribeck;
                              f.mu_s = 0.13;
                              f.stribeck = 0.02;
                          })}),
    [](const auto& law) { return std::string{law.param.name}; });

}  // namespace
}  // namespace shaker::reduction
