// A bench that requires real time, on a computer that grants neither locked memory nor a priority: nothing is
// driven.
#include <gtest/gtest.h>
#include <linux/capability.h>
#include <sys/prctl.h>
#include <sys/resource.h>

#include <chrono>
#include <csignal>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <memory>
#include <thread>

#include "tests/support/in_real_time.hpp"
#include "tests/support/remote/tcp_client.hpp"
#include "tests/support/run/bench_run.hpp"

namespace shaker::test {
namespace {

constexpr const char* refused = "a drive without it may stop by itself at any time";

std::string content(const std::filesystem::path& file) {
    std::ifstream in{file, std::ios::binary};
    return {std::istreambuf_iterator<char>{in}, {}};
}

struct RealTimeRightTest : testing::Test {
    BenchRun run;

    void SetUp() override {
        if (!in_real_time) GTEST_SKIP() << "not in real time under a sanitiser";
        run.rig("real_time", "\"required\"");
        run.rig("second_channel", "\"trigger\"\ndither = false");
    }
    /// The program has no rights that its parent could have. The limits of this process stay lowered.
    std::unique_ptr<Program> start(const std::string& arguments) {
        std::unique_ptr<Program> program;
        std::jthread{[&] {
            for (const int right : {CAP_SYS_RESOURCE, CAP_SYS_NICE, CAP_IPC_LOCK})
                ::prctl(PR_CAPBSET_DROP, right, 0, 0, 0);
            const rlimit none{0, 0};
            for (const auto limit : {RLIMIT_MEMLOCK, RLIMIT_RTPRIO}) ::setrlimit(limit, &none);
            program = std::make_unique<Program>("shakerd", arguments, run.folder);
        }}.join();
        return program;
    }
    std::unique_ptr<Program> start_on_bench(const std::string& command) {
        return start(command + " --rig '" + run.bench.rig_file().string() + "'");
    }
    void expect_silence() {
        std::ifstream in{run.folder / "codes", std::ios::binary};
        std::int32_t pair[2];
        std::size_t samples = 0, loud = 0;
        for (; in.read(reinterpret_cast<char*>(pair), sizeof pair); ++samples) loud += pair[0] != 0 ? 1 : 0;
        EXPECT_GT(samples, 0U);
        EXPECT_EQ(loud, 0U) << "samples of the drive that differ from zero";
    }
};

TEST_F(RealTimeRightTest, RunAndCheckEndWithoutDrive) {
    for (const char* command : {"run --no-identify --periods 4", "check"}) {
        SCOPED_TRACE(command);
        const Outcome o = start_on_bench(command)->wait(60);
        EXPECT_EQ(o.status, 3) << o.out << end_of(o.err);
        EXPECT_NE((o.out + o.err).find(refused), std::string::npos) << o.out << end_of(o.err);
    }
    expect_silence();
}

TEST_F(RealTimeRightTest, ServiceRefusesToDrive) {
    const std::string socket = (run.folder / "scpi").string();
    std::ofstream{run.folder / "settings.toml"} << "[serve]\nhttp_port = 0\nscpi_port = 0\nscpi_socket = \"" +
                                                       socket + "\"\nrecordings = \".\"\n[run]\nrig = \"" +
                                                       run.bench.rig_file().string() +
                                                       "\"\nframes = \"off\"\n";
    const auto program = start("serve --settings settings.toml");
    for (int i = 0; i < 1000 && !program->ended(); ++i) {
        if (content(program->said()).find("state: idle") != std::string::npos) break;
        std::this_thread::sleep_for(std::chrono::milliseconds{20});
    }
    ASSERT_FALSE(program->ended()) << content(program->said());
    TcpClient client{std::filesystem::path{socket}};
    client.send("OUTP ON;*WAI");
    const std::string error = client.ask("SYST:ERR?");
    EXPECT_NE(error.find(refused), std::string::npos) << error;
    EXPECT_EQ(client.ask("OUTP?"), "0");
    ::kill(program->pid(), SIGTERM);
    EXPECT_EQ(program->wait(20).status, 0);
    expect_silence();
}

}  // namespace
}  // namespace shaker::test
