// Runs with an analog accelerometer on the inputs of a sound card: real libasound in both directions.
#include <gtest/gtest.h>
#include <spdlog/fmt/fmt.h>

#include <iostream>
#include <nlohmann/json.hpp>
#include <numbers>

#include "drivers/drive.hpp"
#include "drivers/recorded/h5/h5.hpp"
#include "drivers/simulated/scene.hpp"
#include "tests/mock/sound/line_memory.hpp"
#include "tests/support/in_real_time.hpp"
#include "tests/support/nightly.hpp"
#include "tests/support/run/bench_run.hpp"

namespace shaker::test {
namespace {

// One card: the sensor has the clock of the drive. The corner of 0.05 Hz turns phi by 3.75 mrad at 20 Hz.
const std::string one_card =
    "[accelerometer]\naxes = 1\ngravity = 0\nhigh_pass_hz = 0.05\nyaw_deg = 0\nrate_hz = 48000\nclock_ppm = "
    "0\n"
    "bits = 24\n";

TEST(LineInputTest, ResultsAreTrueOnOneCard) {
    BenchRun run{37.5, one_card, true};
    run.start("--gamma 1g --phi 100deg --periods 40 -o run.nxs");
    if (!in_real_time) return expect_order(run.finish());
    const nlohmann::json r = run.results();
    ASSERT_FALSE(r.empty());
    EXPECT_NEAR(r.at("gamma_mps2"), 9.8, 0.01);
    EXPECT_NEAR(r.at("dac_ppm"), 37.5, 1);
    EXPECT_EQ(device(r, "input shaker_line").at("lost"), 0);
    EXPECT_TRUE(r.at("bench_check").at("tilt_rad").is_null());
    EXPECT_TRUE(r.at("harmonics").at(0).at("across").is_null());
    EXPECT_TRUE(noted(r, "motion across the shaker's axis is not known"));
    EXPECT_TRUE(noted(r, "tilt by gravity is not known"));
    const double v_true = run.bench.drift(1, r.at("from_s"), r.at("to_s"), r.at("frequency_hz"));
    EXPECT_NEAR(r.at("v_D_mps"), v_true, 8 * r.at("v_D_se_mps").get<double>() + 1e-4 * v_true);
    const Outcome again = shakerd("replay run.nxs", run.folder);
    EXPECT_EQ(again.status, 0) << again.out << again.err;
}

TEST(LineInputTest, AnInputThatIsUnpluggedStopsTheDrive) {
    BenchRun run{0, one_card, true};
    run.start("--gamma 0.5g --periods 2000");
    if (!in_real_time) return expect_order(run.finish());
    ASSERT_TRUE(run.played(6)) << end_of(run.finish().err);
    run.bench.line_input().unplug();
    const Outcome o = run.finish();
    EXPECT_EQ(o.status, 5) << end_of(o.err);
    EXPECT_NE((o.out + o.err).find("sensor_missing"), std::string::npos) << o.out << end_of(o.err);
}

// Drive and sensor are counted by one clock: the delay of the samples is one constant. tests/run --nightly:
// ten minutes, of which this is the start. The walker rests.
TEST(LineInputTest, EightChannelsAt96KilohertzLoseNothing) {
    constexpr double rate_hz = 96000, period_s = 0.05;
    const int periods = static_cast<int>((nightly() ? 600 : 10) / period_s);
    std::string scene = one_card;
    scene.replace(scene.find("48000"), 5, "96000");
    BenchRun run{37.5, scene + "[dac]\nrate_hz = 96000\n", true, 8};
    run.start(fmt::format("--gamma 0.1g --periods {} -o run.nxs --frames off", periods));
    if (!in_real_time) return expect_order(run.finish());
    const Outcome o = run.program().wait(800);
    ASSERT_EQ(o.status, 0) << end_of(o.err);
    const auto r = nlohmann::json::parse(o.out);
    EXPECT_EQ(device(r, "input shaker_line").at("lost"), 0);
    EXPECT_EQ(run.bench.dac().counts().underruns, 0U);
    const auto file = h5::open_file(run.folder / "run.nxs");
    const auto of = [&](const char* name) {
        return h5::read<double>(file.get(), std::string{"entry/results/"} + name).at(0);
    };
    const simulated::AccelerometerTruth truth = simulated::paper_scene().accelerometer;
    const double shown_s = 1e-9 * mock::LineMemory::shown_after_ns + 1 / rate_hz - truth.start_s;
    const double late_s = shown_s + std::numbers::sqrt2 / (two_pi * truth.lowpass_hz);  // of the sensor
    const double told_s = of("accelerometer_late"), error_s = of("accelerometer_late_errors");
    std::cout << fmt::format("true delay {:.7f} s, found {:.7f} +- {:.7f} s; {:.2f} of a core\n", late_s,
                             told_s, error_s, o.cpu_s / (periods * period_s));
    EXPECT_NEAR(told_s, late_s, 6 * error_s + 0.1 / rate_hz);
}

}  // namespace
}  // namespace shaker::test
