// shakerd check --loopback: a cable from the output to the input of a mock sound card.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/mock/mock_bench.hpp"
#include "tests/mock/sound/line_memory.hpp"
#include "tests/support/devices/mock_cameras.hpp"
#include "tests/support/in_real_time.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/program.hpp"

namespace shaker::test {
namespace {

/// A bench whose input is 0.8 V full scale, with a cable of this gain.
struct CableBench {
    explicit CableBench(double cable) : folder{fresh_folder()}, bench{settings(folder, cable)} {}
    static mock::MockBenchSettings settings(const std::filesystem::path& folder, double cable) {
        if (const std::string refused = private_network(); !refused.empty())
            throw std::runtime_error{refused};
        mock::MockBenchSettings s;
        s.scene = simulated::parse_scene(
            "[accelerometer]\naxes = 1\ngravity = 0\nrate_hz = 48000\nclock_ppm = 0\n"
            "bits = 24\nhigh_pass_hz = 1.5\n",
            "test");
        s.folder = folder;
        s.plugin = build_dir() + "/shaker_mock_pcm.so";
        s.line_input = true;
        s.cable = cable;
        return s;
    }
    Outcome check(const std::string& answer) {
        Program program{"shakerd", "check --loopback --json --rig '" + bench.rig_file().string() + "'",
                        folder, answer};
        return program.wait(60);
    }

    std::filesystem::path folder;
    mock::MockBench bench;
};

TEST(LoopbackTest, GainCornerDelayAndNoiseAreThoseOfTheCable) {
    CableBench run{0.25};
    const Outcome o = run.check("off\n");
    if (!in_real_time) return;
    ASSERT_EQ(o.status, 0) << o.err;
    const auto j = nlohmann::json::parse(o.out);
    const double full_V = 0.1 * 78.5 / 9.80665;
    EXPECT_NEAR(j.at("share"), 0.25 / full_V, 2e-4);
    EXPECT_NEAR(j.at("full_scale_V"), full_V / 0.25, 2e-3);
    EXPECT_NEAR(j.at("corner_hz"), 1.5, std::max(0.02, 4 * j.at("corner_hz_se").get<double>()));
    EXPECT_NEAR(j.at("delay_s"), 1e-9 * mock::LineMemory::shown_after_ns + 1 / 48e3, 2e-6);
    EXPECT_NEAR(j.at("noise"), 1e-5 / std::sqrt(12.0), 0.5e-5);
    EXPECT_LT(j.at("distortion"), 1e-3);
    EXPECT_LT(j.at("pulses"), 1e-4);
    EXPECT_NE(o.err.find("60 dB below full scale: the input shows"), std::string::npos) << o.err;
}

TEST(LoopbackTest, WithoutACableNothingLouderIsPlayed) {
    CableBench run{1e-9};
    const Outcome o = run.check("off\n");
    if (!in_real_time) return;
    EXPECT_EQ(o.status, 3) << o.err;
    EXPECT_NE(o.err.find("the input does not show the output: 0.001 V"), std::string::npos) << o.err;
    EXPECT_EQ(o.err.find("40 dB below"), std::string::npos) << o.err;
}

TEST(LoopbackTest, AnotherAnswerPlaysNothing) {
    CableBench run{1};
    const Outcome o = run.check("yes\n");
    EXPECT_EQ(o.status, 2) << o.err;
    EXPECT_NE(o.err.find("nothing was played"), std::string::npos) << o.err;
    EXPECT_EQ(run.bench.dac().counts().frames, 0U);
}

}  // namespace
}  // namespace shaker::test
