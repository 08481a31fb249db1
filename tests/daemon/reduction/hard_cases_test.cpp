// Hard cases by name: each is right, refused or noted; none is silently wrong.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <random>

#include "daemon/reduction/reduction.hpp"
#include "drivers/errors.hpp"
#include "tests/support/run/synthetic_run.hpp"

namespace shaker::reduction {
namespace {

constexpr double pi = std::numbers::pi, nan = std::numeric_limits<double>::quiet_NaN();

enum class Outcome { right, right_with_note, noted, refused };
using enum Outcome;

struct HardCase {
    friend void PrintTo(const HardCase& c, std::ostream* out) { *out << c.name; }

    const char* name;
    Outcome outcome;
    std::string words = {};                              // in the note or the refusal
    std::function<void(SyntheticRun&)> run = {};         // the settings ...
    std::function<void(Measurement&)> measurement = {};  // ... and what happens to the data
};

/// "name: error over standard error" of each number beyond 4.5 standard errors.
std::vector<std::string> wrong_numbers(const Reduction& r, const SyntheticRun& run) {
    std::vector<std::string> out;
    const auto judge = [&](const char* name, const calibration::Estimate& e, double truth, double rounding,
                           double turn = std::numeric_limits<double>::infinity()) {
        const double error = std::remainder(e.value - truth, turn);
        if (std::abs(error) > 4.5 * e.sigma + rounding)
            out.push_back(std::string{name} + ": " + std::to_string(error / e.sigma));
    };
    const Drive& d = run.drive;
    const double middle_s = run.start_s + 0.5 * run.periods / d.frequency;
    judge("v_D", r.v_D, drift_velocity(run), 1e-9);
    judge("frequency", r.frequency, d.frequency, 1e-12);
    judge("gamma", r.gamma, d.gamma, 0);
    judge("rho", r.rho, d.rho, 0);
    if (d.rho > 0 && d.rho < 1) judge("phi", r.phi, d.phi, 0, two_pi);
    const double late_then = (middle_s + run.late_s) / (1 + 1e-6 * run.ppm) - middle_s;
    judge("delay", r.delay_s, late_then, 1e-9 * std::abs(run.ppm));  // the middle is known to 1 ms
    if (d.rho > 0 && d.rho < 1 && !(r.phi.sigma < 0.1 * pi)) out.push_back("phi has no useful error");
    return out;
}

auto frames(double a_second) {
    return [=](SyntheticRun& run) { run.frame_rate_hz = a_second; };
}
auto periods(int n) {
    return [=](SyntheticRun& run) { run.periods = n; };
}
auto drive(double gamma_g, double phi, double rho = 0.5) {
    return [=](SyntheticRun& run) {
        run.drive = {20, gamma_g * paper_g, rho, phi};
        run.may_stick = true;
    };
}
auto frequency(double hz, double frame_rate_hz = 1000, double accel_rate_hz = 4000) {
    return [=](SyntheticRun& run) {
        run.drive.frequency = hz;
        run.frame_rate_hz = frame_rate_hz;
        run.accel_rate_hz = accel_rate_hz;
        run.late_s = 0.3 / hz > 0.0123 ? 0.0123 : 0.3 / hz;
    };
}
auto each(std::function<void(MotionSeries&)> change) {
    return [=](Measurement& m) {
        for (auto* views : {&m.walkers, &m.bases}) std::ranges::for_each(*views, change);
    };
}
/// Keeps the frames for which `keep` is true.
auto lose(std::function<bool(std::size_t)> keep) {
    return each([=](MotionSeries& s) {
        MotionSeries kept;
        kept.view = s.view;
        for (std::size_t i = 0; i < s.t_s.size(); ++i) {
            if (!keep(i)) {
                ++kept.lost;
                continue;
            }
            kept.t_s.push_back(s.t_s[i]);
            kept.x_m.push_back(s.x_m[i]);
            kept.sd_m.push_back(s.sd_m[i]);
        }
        s = kept;
    });
}
/// Harmonic q of the base, `share` of gamma, in phase with the drive; of 40 periods of the usual run.
auto harmonic(int q, double share) {
    return [=](Measurement& m) {
        const SyntheticRun run;
        const double w = two_pi * run.drive.frequency * q, a = share * run.drive.gamma;
        for (MotionSeries& s : m.bases)
            for (std::size_t i = 0; i < s.t_s.size(); ++i) s.x_m[i] -= a / (w * w) * std::cos(w * s.t_s[i]);
        for (std::size_t i = 0; i < m.accelerometer.t_s.size(); ++i) {
            const double t = m.accelerometer.t_s[i] * (1 + 1e-6 * run.ppm) - run.late_s;
            for (std::size_t k = 0; k < 3; ++k)
                m.accelerometer.a_mps2[i][k] += a * std::cos(w * t) * run.axis[k];
        }
    };
}
auto late(double seconds) {
    return [=](SyntheticRun& run) { run.late_s = seconds; };
}

const HardCase cases[] = {
    {"two periods", right_with_note, "whole periods are too few", periods(2)},
    {"three periods", right_with_note, "too short for the memory", periods(3)},
    {"five periods", right, "", periods(5)},
    {"400 periods", right, "",
     [](SyntheticRun& r) { r.periods = 400, r.frame_rate_hz = 400, r.late_s = 0.005; }},
    {"one view", right, "", [](SyntheticRun& r) { r.views = 1; }},
    {"half of the frames lost", right_with_note, "lost", {}, lose([](std::size_t i) {
         return i * 7919 % 97 < 48;
     })},
    {"nine tenths lost", right_with_note, "lost", {}, lose([](std::size_t i) {
         return i * 2654435761U % 4294967296U / 429496730U == 0;
     })},
    {"250 frames missing", right_with_note, "lost", {}, lose([](std::size_t i) {
         return i < 700 || i >= 950;
     })},
    {"out of view for 40 %", right_with_note, "lost", {}, lose([](std::size_t i) {
         return i < 500 || i > 1300;
     })},
    {"997 frames/s", right, "", frames(997)},
    {"480.1 frames/s", right, "", frames(480.1)},
    {"333.33 frames/s", right, "", frames(333.33)},
    {"250 frames/s", right, "", frames(250)},
    {"12 frames a period", right, "", frames(240)},
    {"50 frames a period", right, "", frames(1000)},
    {"10 frames a period", right, "", frames(200)},
    {"8 frames a period", right, "", frames(160)},
    {"5 frames a period", right, "", frames(100)},
    {"4 frames a period", refused, "at least 5 are required", frames(80)},
    {"41 frames/s", refused, "at least 5 are required", frames(41)},
    {"40.02 frames/s", refused, "at least 5 are required", frames(40.02)},
    {"third harmonic 5 %", right, "", {}, harmonic(3, 0.05)},
    {"fifth harmonic 5 %", right, "", {}, harmonic(5, 0.05)},
    {"ninth harmonic 5 %", right, "", {}, harmonic(9, 0.05)},
    {"fifth harmonic, 10 frames a period", right, "", frames(200), harmonic(5, 0.05)},
    {"rests", right, "", drive(0.1, 0)},
    {"threshold of motion", right, "", drive(0.128, 0)},
    {"sticks mostly", right, "", drive(0.2, 0)},
    {"null phase", right, "", drive(1, 2.1711)},
    {"3 g", right, "", drive(3, 0)},
    {"10 g", right, "", drive(10, 0)},
    {"phi 180 degrees", right, "", drive(1, pi)},
    {"phi -179.99 degrees", right, "", drive(1, -pi + 2e-4)},
    {"phi -90 degrees", right, "", drive(1, -pi / 2)},
    {"5 Hz", right, "", frequency(5)},
    {"10 Hz", right, "", frequency(10)},
    {"15 Hz", right, "", frequency(15)},
    {"25 Hz", right, "", frequency(25)},
    {"50 Hz", right_with_note, "lags of the accelerometer", frequency(50)},
    {"100 Hz", right_with_note, "lags of the accelerometer", frequency(100, 2000)},
    {"200 Hz", right_with_note, "lags of the accelerometer", frequency(200, 4000, 8000)},
    {"rho 0.2", right, "", drive(1.5, 0, 0.2)},
    {"rho 0.3", right, "", drive(1.5, 0, 0.3)},
    {"rho 0.7", right, "", drive(1.5, 0, 0.7)},
    {"rho 0.8", right, "", drive(1.5, 0, 0.8)},
    {"rho 0", noted, "the lag's error contains the others", drive(3, 0, 0)},
    {"rho 1", noted, "sign of the shaker axis", drive(1.5, 0, 1)},
    {"nominal frequency 1 % off", right, "", {}, [](Measurement& m) { m.frequency_hz *= 1.01; }},
    {"nominal frequency 5 % off", right, "", {}, [](Measurement& m) { m.frequency_hz *= 1.05; }},
    {"100 ppm", right, "", [](SyntheticRun& r) { r.ppm = 100; }},
    {"1000 ppm", right_with_note, "a crystal is within 400 ppm", [](SyntheticRun& r) { r.ppm = 1000; }},
    {"5000 ppm", right_with_note, "a crystal is within 400 ppm", [](SyntheticRun& r) { r.ppm = 5000; }},
    {"-20000 ppm", noted, "a crystal is within 400 ppm", [](SyntheticRun& r) { r.ppm = -20000; }},
    {"frame rate told 1 % wrong", noted, "a crystal is within 400 ppm", {}, each([](MotionSeries& s) {
         for (double& t : s.t_s) t *= 1.01;
     })},
    {"frame rate told 0.1 % wrong", noted, "a crystal is within 400 ppm", {}, each([](MotionSeries& s) {
         for (double& t : s.t_s) t *= 0.999;
     })},
    {"noise of 50 um", right, "", [](SyntheticRun& r) { r.position_noise_m = 50e-6; }},
    {"claimed errors 5 times too small", right, "", {}, each([](MotionSeries& s) {
         for (double& sd : s.sd_m) sd /= 5;
     })},
    {"noise with memory", right, "", [](SyntheticRun& r) { r.noise_memory = 0.9; }},
    {"friction with memory", right, "", [](SyntheticRun& r) { r.drift_jitter = 0.02, r.drift_memory = 0.8; }},
    {"walker settles", right_with_note, "still settling",
     [](SyntheticRun& r) { r.settling = -0.3, r.contraction = 0.9; }},
    {"one view 1 % larger",
     right_with_note,
     "differ in v_D",
     {},
     [](Measurement& m) {
         for (auto* views : {&m.walkers, &m.bases})
             for (double& x : views->at(1).x_m) x *= 1.01;
     }},
    {"one sample of 100 m/s^2",
     right,
     "",
     {},
     [](Measurement& m) { m.accelerometer.a_mps2[2000][0] += 100; }},
    {"one sample of 1e6 m/s^2", right, "", {}, [](Measurement& m) { m.accelerometer.a_mps2[2000][0] = 1e6; }},
    {"frozen axis",
     noted,
     "",
     {},
     [](Measurement& m) {
         for (std::size_t i = 2000; i < 2160; ++i)
             m.accelerometer.a_mps2[i][0] = m.accelerometer.a_mps2[1999][0];
     }},
    {"20 ms of the sensor missing",
     right,
     "",
     {},
     [](Measurement& m) {
         auto& a = m.accelerometer;
         a.t_s.erase(a.t_s.begin() + 2000, a.t_s.begin() + 2080);
         a.a_mps2.erase(a.a_mps2.begin() + 2000, a.a_mps2.begin() + 2080);
     }},
    {"clock 19.9 ms late", right, "", late(0.0199)},
    {"clock 5 ms early", right, "", late(-0.005)},
    {"clock 28 ms late of 20 allowed", noted, "clock uncertainty", late(0.028)},
    {"all times a million seconds later",
     right,
     "",
     {},
     [](Measurement& m) {
         for (double& t : m.accelerometer.t_s) t += 1e6;
         each([](MotionSeries& s) {
             for (double& t : s.t_s) t += 1e6;
         })(m);
     }},
    {"a position that is not a number", refused, "", {}, [](Measurement& m) { m.walkers[0].x_m[100] = nan; }},
    {"a time that steps back", refused, "", {}, [](Measurement& m) { m.walkers[0].t_s[100] -= 0.01; }},
    {"a sample that is not a number",
     refused,
     "",
     {},
     [](Measurement& m) { m.accelerometer.a_mps2[100][1] = nan; }},
};

class HardCaseTest : public ::testing::TestWithParam<HardCase> {};

TEST_P(HardCaseTest, IsNotSilentlyWrong) {
    const HardCase& c = GetParam();
    SyntheticRun run;
    run.views = 2;
    if (c.run) c.run(run);
    Measurement m = make_measurement(run);
    if (c.measurement) c.measurement(m);
    Reduction r;
    try {
        r = reduce(std::move(m));
    } catch (const InputError& e) {
        EXPECT_EQ(c.outcome, refused) << e.what();
        EXPECT_NE(std::string{e.what()}.find(c.words), std::string::npos) << e.what();
        return;
    }
    ASSERT_NE(c.outcome, refused) << "was reduced";
    std::string said, wrong;
    for (const std::string& note : r.notes) said += note + "\n";
    for (const std::string& number : wrong_numbers(r, run)) wrong += number + "\n";
    if (c.outcome != noted) {
        EXPECT_EQ(wrong, "") << said;
    }
    if (c.outcome == right) {
        EXPECT_EQ(said, "");
    } else {
        EXPECT_NE(said, "") << wrong;
        EXPECT_NE(said.find(c.words), std::string::npos) << said;
    }
}

std::string identifier(const ::testing::TestParamInfo<HardCase>& hard) {
    std::string name = hard.param.name;
    std::ranges::replace_if(
        name, [](unsigned char c) { return std::isalnum(c) == 0; }, '_');
    return name;
}

INSTANTIATE_TEST_SUITE_P(Cases, HardCaseTest, ::testing::ValuesIn(cases), identifier);

}  // namespace
}  // namespace shaker::reduction
