// Signals to commands that drive the shaker.
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <fstream>
#include <thread>

#include "tests/support/nightly.hpp"
#include "tests/support/program.hpp"

namespace shaker::commands {
namespace {

constexpr const char* slow =
    "[top]\npositions = 1\nframe_rate_hz = 100\n[side]\npositions = 1\nframe_rate_hz = 100\n";

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

// Three programs at a time, one for each signal. Nightly after an identification, which takes six seconds of
// real time.
TEST(StopSignalsTest, RunStopsSoftlyAndKeepsWhatItMeasured) {
    const std::string identify = test::nightly() ? "" : "--no-identify ";
    struct Run {
        int signal;
        std::filesystem::path folder;
        std::unique_ptr<test::Program> program;
    };
    const auto all = test::fresh_folder();
    std::vector<Run> runs;
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
        const auto folder = all / std::to_string(signal);
        std::filesystem::create_directory(folder);
        std::ofstream{folder / "slow.toml"} << slow;
        runs.push_back({signal, folder,
                        std::make_unique<test::Program>(
                            "shakerd",
                            "run --rig sim: --scene slow.toml --real-time --threads --phi 1.75 --settle 4 " +
                                identify + "--periods 2000 --frames off -o run.nxs",
                            folder)});
    }
    for (const Run& run : runs) ASSERT_TRUE(logged(*run.program, "measuring 2000 periods"));
    std::this_thread::sleep_for(std::chrono::milliseconds{500});
    for (const Run& run : runs) kill(run.program->pid(), run.signal);
    for (const auto& [signal, folder, run] : runs) {
        const test::Outcome o = run->wait(60);
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
                      "run --rig sim: --scene slow.toml --real-time --threads --frequency 5 --gamma 0.05 "
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
