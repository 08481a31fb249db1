// Errors of v_D in a campaign's table: others narrow them, and no doubt is lost.
#include "daemon/campaign/common_errors.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace shaker::campaign {
namespace {

constexpr double frequency_hz = 20, error_m = 0.2e-6, amplitude_m = 90e-6;

/// A steady walker, with an error of v_D by the scatter of its periods and by a doubt, m/s.
recording::MeasuredResult measured(int periods, double doubt_mps, std::mt19937_64& random) {
    std::normal_distribution<double> error{0, error_m};
    recording::MeasuredResult out;
    out.measurement.asked.frequency = frequency_hz;
    out.measurement.part = {0, periods / frequency_hz};
    reduction::Reduction r;
    constexpr int frames = 100, phases = 64;
    double before = error(random);
    for (int k = 0; k < periods; ++k) {
        const double now = k == 0 ? before : error(random);
        reduction::PeriodResult& period = r.periods.emplace_back();
        period.k = k;
        period.frames = frames;
        period.drift = {k == 0 ? NAN : now - before, error_m};
        before = now;
    }
    for (int i = 0; i < phases; ++i) {
        r.cycle.phase.push_back(i / double{phases});
        r.cycle.x_m.push_back(amplitude_m * std::cos(2 * std::numbers::pi * i / phases));
    }
    r.fit_residual_x_m = {error_m * std::sqrt(frames), error_m};
    r.v_rms = {0.05, 1e-5};
    r.v_D_settled = {NAN, NAN};
    r.v_D = {0.01, std::hypot(frequency_hz * error_m * std::sqrt(12 / std::pow(periods, 3)), doubt_mps)};
    r.D = {r.v_D.value / frequency_hz, r.v_D.sigma / frequency_hz};
    r.efficiency = {r.v_D.value / r.v_rms.value, r.v_D.sigma / r.v_rms.value};
    out.reduction = r;
    return out;
}

// A frame rate or a view that is in doubt is in the error of one measurement; the others know nothing of it.
TEST(CommonErrorsTest, DoubtBeyondTheScatterStays) {
    for (const int periods : {5, 10, 40}) {
        std::mt19937_64 random{5};
        const double scatter = frequency_hz * error_m * std::sqrt(12 / std::pow(periods, 3));
        std::vector<recording::MeasuredResult> all;
        for (int i = 0; i < 12; ++i) all.push_back(measured(periods, i == 3 ? 5 * scatter : 0, random));
        std::vector<recording::MeasuredResult*> pointers;
        for (auto& m : all) pointers.push_back(&m);
        state_common_errors(pointers);
        const reduction::Reduction& doubted = *all[3].reduction;
        EXPECT_GE(doubted.v_D.sigma, 4 * scatter) << periods;
        EXPECT_NEAR(doubted.D.sigma, doubted.v_D.sigma / frequency_hz, 1e-12);
        EXPECT_NEAR(doubted.efficiency.sigma, doubted.v_D.sigma / doubted.v_rms.value, 1e-9);
        EXPECT_LE(all[4].reduction->v_D.sigma, 2 * scatter) << periods;
    }
}

TEST(CommonErrorsTest, OneAloneAndOneThatStillSettlesKeepTheirErrors) {
    std::mt19937_64 random{6};
    std::vector<recording::MeasuredResult> all;
    for (int i = 0; i < 3; ++i) all.push_back(measured(10, 0, random));
    all[0].reduction->v_D_settled = {0.0101, 1e-5};
    const double settling = all[0].reduction->v_D.sigma, alone = all[1].reduction->v_D.sigma;
    state_common_errors({&all[1]});
    EXPECT_EQ(all[1].reduction->v_D.sigma, alone);
    state_common_errors({&all[0], &all[1], &all[2]});
    EXPECT_EQ(all[0].reduction->v_D.sigma, settling);
    EXPECT_NE(all[1].reduction->v_D.sigma, alone);
}

}  // namespace
}  // namespace shaker::campaign
