// Runs whose cameras give positions instead of pixels.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "drivers/recorded/recording_file.hpp"
#include "tests/support/program.hpp"

namespace shaker::run {
namespace {

using test::fresh_folder;
using test::Outcome;
using test::shakerd;

constexpr const char* scene = "[top]\npositions = 1\n[side]\npositions = 1\n";

TEST(PositionsTest, RunMeasuresAndReplaysToTheBit) {
    const auto folder = fresh_folder();
    std::ofstream{folder / "scene.toml"} << scene;
    const Outcome run =
        shakerd("run --json --rig sim: --scene scene.toml --phi 2.17 --periods 20 -o run.nxs", folder);
    ASSERT_EQ(run.status, 0) << run.err;
    const nlohmann::json r = nlohmann::json::parse(run.out);
    const double v = r["v_D_mps"], se = r["v_D_se_mps"], truth = r["v_D_true_mps"];
    EXPECT_LE(std::abs(v - truth), 4 * se) << v << " is not " << truth;
    EXPECT_LT(se, 2e-6);
    const recorded::RecordingReader file{folder / "run.nxs"};
    EXPECT_EQ(file.frames_without_picture(), 0U) << "these cameras have none";
    ASSERT_FALSE(file.frames("top").empty());
    EXPECT_EQ(file.frames("top").front().sightings.size(), 2U);
    for (const char* from : {"", " --from raw", " --from tracks"}) {
        const Outcome replay = shakerd(std::string{"replay run.nxs"} + from, folder);
        EXPECT_EQ(replay.status, 0) << replay.out << replay.err;
        EXPECT_NE(replay.out.find("identical"), std::string::npos) << replay.out;
    }
}

// Common noise of two cameras would make every error too small by the root of 2.
TEST(PositionsTest, CamerasHaveNoiseOfTheirOwn) {
    const auto folder = fresh_folder();
    std::ofstream{folder / "scene.toml"} << scene;
    ASSERT_EQ(
        shakerd("run --no-identify --rig sim: --scene scene.toml --periods 4 -o run.nxs", folder).status, 0);
    const recorded::RecordingReader file{folder / "run.nxs"};
    const auto top = file.frames("top"), side = file.frames("side");
    constexpr std::size_t at_rest = 300;  // the self-test begins in silence
    ASSERT_GT(std::min(top.size(), side.size()), at_rest);
    double common = 0, all = 0;
    for (std::size_t i = 1; i < at_rest; ++i) {
        const auto step = [i](const auto& frames) {
            return frames[i].sightings.front().x_px - frames[i - 1].sightings.front().x_px;
        };
        common += step(top) * step(side);
        all += step(top) * step(top) / 2 + step(side) * step(side) / 2;
    }
    EXPECT_LT(std::abs(common / all), 0.2);
}

TEST(PositionsTest, StoppedRunReplaysToo) {
    const auto folder = fresh_folder();
    std::ofstream{folder / "scene.toml"} << scene << "[[fault]]\nwhat = \"open\"\nat_s = 4\n";
    const Outcome run =
        shakerd("run --rig sim: --scene scene.toml --phi 2.17 --periods 40 -o run.nxs", folder);
    EXPECT_EQ(run.status, 5) << run.err;
    const Outcome replay = shakerd("replay run.nxs", folder);
    EXPECT_EQ(replay.status, 0) << replay.out << replay.err;
    const Outcome verify = shakerd("recover run.nxs", folder);
    EXPECT_EQ(verify.status, 0) << verify.out << verify.err;
}

// The program measures the rates itself. A stated rate that is 1 % wrong changes no result.
TEST(PositionsTest, WrongStatedRatesChangeNoResult) {
    const auto folder = fresh_folder();
    for (const char* ppm : {"-10000", "1000", "10000"}) {
        const std::string wrong = std::string{"clock_ppm = "} + ppm + "\n";
        std::ofstream{folder / "scene.toml"} << "[accelerometer]\n"
                                             << wrong << "[top]\npositions = 1\n"
                                             << wrong << "[side]\npositions = 1\n";
        const Outcome run =
            shakerd("run --json --no-identify --rig sim: --scene scene.toml --gamma 1g --periods 20", folder);
        ASSERT_EQ(run.status, 0) << run.err;
        const nlohmann::json r = nlohmann::json::parse(run.out);
        const double v = r["v_D_mps"], se = r["v_D_se_mps"], truth = r["v_D_true_mps"],
                     gamma = r["gamma_mps2"];
        EXPECT_LE(std::abs(v - truth), 4 * se) << ppm;
        EXPECT_LT(se, 7e-6) << ppm;
        EXPECT_LT(std::abs(gamma - 9.8), 4 * r["gamma_se_mps2"].get<double>() + 1e-3 * 9.8) << ppm;
    }
}

}  // namespace
}  // namespace shaker::run
