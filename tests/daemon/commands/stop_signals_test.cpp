// Signals to commands that drive the shaker.
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <fstream>
#include <thread>

#include "tests/support/program.hpp"

namespace shaker::commands {
namespace {

constexpr const char* slow = "[top]\nframe_rate_hz = 100\n[side]\nframe_rate_hz = 100\n";

// Waits until the program has logged a text; false after 60 s.
bool logged(const test::Program& program, const std::string& text) {
    for (int i = 0; i < 6000; ++i) {
        std::ifstream in{program.said()};
        const std::string said{std::istreambuf_iterator<char>{in}, {}};
        if (said.find(text) != std::string::npos) return true;
        std::this_thread::sleep_for(std::chrono::milliseconds{10});
    }
    return false;
}

TEST(StopSignalsTest, RunStopsSoftlyAndKeepsWhatItMeasured) {
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
        const auto folder = test::fresh_folder();
        std::ofstream{folder / "slow.toml"} << slow;
        test::Program run{"shakerd",
                          "run --rig sim: --scene slow.toml --real-time --threads --phi 1.75 --settle 4 "
                          "--periods 2000 --frames off -o run.nxs",
                          folder};
        ASSERT_TRUE(logged(run, "measuring 2000 periods"));
        std::this_thread::sleep_for(std::chrono::milliseconds{500});
        kill(run.pid(), signal);
        const test::Outcome o = run.wait(60);
        EXPECT_EQ(o.status, 128 + signal) << o.err;
        EXPECT_NE(o.err.find("soft stop"), std::string::npos) << o.err;
        EXPECT_NE(o.err.find("interrupted by SIG"), std::string::npos) << o.err;
        EXPECT_NE(o.out.find("v_D"), std::string::npos) << o.out << o.err;
        EXPECT_TRUE(std::filesystem::exists(folder / "run.nxs")) << "a complete file";
        const test::Outcome again = test::shakerd("replay run.nxs", folder);
        EXPECT_EQ(again.status, 0) << again.out << again.err;
    }
}

TEST(StopSignalsTest, SecondSignalAborts) {
    const auto folder = test::fresh_folder();
    std::ofstream{folder / "slow.toml"} << slow;
    test::Program run{"shakerd",
                      "run --rig sim: --scene slow.toml --real-time --threads --frequency 2 --gamma 0.05 "
                      "--no-identify --periods 100 --trips .",
                      folder};
    ASSERT_TRUE(logged(run, "soft start"));
    std::this_thread::sleep_for(std::chrono::milliseconds{500});
    kill(run.pid(), SIGINT);
    std::this_thread::sleep_for(std::chrono::milliseconds{300});
    kill(run.pid(), SIGINT);
    const test::Outcome o = run.wait(60);
    EXPECT_EQ(o.status, 5) << o.err;
    EXPECT_NE(o.err.find("operator_stop"), std::string::npos) << o.err;
}

TEST(StopSignalsTest, CheckStopsSoftly) {
    const auto folder = test::fresh_folder();
    std::ofstream{folder / "slow.toml"} << slow << "dac_buffer_s = 0\n";
    test::Program check{"shakerd", "check --rig sim: --frequency 1", folder};
    ASSERT_TRUE(logged(check, "self-test"));
    kill(check.pid(), SIGTERM);
    const test::Outcome o = check.wait(60);
    EXPECT_EQ(o.status, 3) << o.out << o.err;
    EXPECT_NE(o.out.find("interrupted"), std::string::npos) << o.out;
}

}  // namespace
}  // namespace shaker::commands
