// The daemon from outside: signals, service manager, settings, disk.
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/ptrace.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <mutex>
#include <thread>

#include "tests/support/environment.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/remote/served_bench.hpp"
#include "tests/support/remote/service_manager.hpp"

namespace shaker::test {
namespace {

using Clock = std::chrono::steady_clock;

pid_t thread_named(pid_t process, const std::string& name) {
    for (const auto& entry :
         std::filesystem::directory_iterator{"/proc/" + std::to_string(process) + "/task"}) {
        std::string comm;
        std::ifstream{entry.path() / "comm"} >> comm;
        if (comm == name) return std::stoi(entry.path().filename().string());
    }
    return -1;
}

void run_recorded(ServedBench& bench, const std::string& name) {
    TcpClient client{bench.scpi_port()};
    client.send("REC ON,\"" + name + "\";:OUTP ON");
    EXPECT_EQ(client.ask("SYST:ERR?"), "0,\"No error\"");
    EXPECT_TRUE(bench.becomes("run")) << bench.log();
}

TEST(ServeTest, SigtermStopsSoftlyAndFinishesRecording) {
    ServiceManager manager;
    ServedBench bench;
    EXPECT_TRUE(manager.hears("READY=1", 5));
    run_recorded(bench, "ended");
    kill(bench.program().pid(), SIGTERM);
    EXPECT_TRUE(manager.hears("STOPPING=1", 5));
    const Outcome o = bench.program().wait(20);
    EXPECT_EQ(o.status, 0) << o.err;
    EXPECT_NE(o.err.find("ramp_down"), std::string::npos) << o.err;
    EXPECT_TRUE(std::filesystem::exists(bench.folder / "ended.nxs"));
    EXPECT_EQ(shakerd("recover ended.nxs", bench.folder).status, 0) << "a finished file is verified";
}

TEST(ServeTest, ManagerWaitsWhileStoppingDaemonLives) {
    ServiceManager manager;
    ServedBench bench;
    run_recorded(bench, "waited");
    EXPECT_FALSE(manager.hears("EXTEND_TIMEOUT_USEC", 0.3)) << "before the stop";
    kill(bench.program().pid(), SIGTERM);
    EXPECT_TRUE(manager.hears("EXTEND_TIMEOUT_USEC=10000000", 5));
    EXPECT_EQ(bench.program().wait(20).status, 0);
}

TEST(ServeTest, SecondSigtermAborts) {
    ServedBench bench{"phi_rad = 1.745\nperiods = 10\nfrequency_hz = 10\ngamma_mps2 = 2\n"};
    run_recorded(bench, "aborted");
    kill(bench.program().pid(), SIGTERM);
    EXPECT_TRUE(bench.logged("ramp_down", 5)) << bench.log();
    kill(bench.program().pid(), SIGTERM);
    const Outcome o = bench.program().wait(20);
    EXPECT_EQ(o.status, 0) << o.err;
    EXPECT_NE(o.err.find("operator_stop"), std::string::npos) << o.err;
    EXPECT_EQ(shakerd("recover aborted.nxs", bench.folder).status, 0);
}

TEST(ServeTest, SigkillLeavesRecoverableFileAndDisarmedDaemon) {
    ServedBench bench;
    run_recorded(bench, "killed");
    std::this_thread::sleep_for(std::chrono::seconds{2});
    kill(bench.program().pid(), SIGKILL);
    EXPECT_EQ(bench.program().wait(20).status, 128 + SIGKILL);
    EXPECT_FALSE(std::filesystem::exists(bench.folder / "killed.nxs"));
    const Outcome recovered = shakerd("recover killed.nxs", bench.folder);
    EXPECT_EQ(recovered.status, 0) << recovered.err;
    EXPECT_TRUE(std::filesystem::exists(bench.folder / "killed.nxs"));
    ServedBench next;
    TcpClient client{next.scpi_port()};
    EXPECT_EQ(client.ask("OUTP?;:SYST:STAT?"), "0;\"idle\"");
}

// Virtual time pauses with the computer, because the simulated bench waits for its readers.
TEST(ServeTest, PausesOfComputerDoNotStopSimulatedRun) {
    ServedBench bench;
    TcpClient client{bench.scpi_port()};
    client.send("OUTP ON");
    ASSERT_TRUE(bench.becomes("run")) << bench.log();
    for (int ms = 20; ms < 100; ms += 4) {
        kill(bench.program().pid(), SIGSTOP);
        std::this_thread::sleep_for(std::chrono::milliseconds{ms});
        kill(bench.program().pid(), SIGCONT);
        std::this_thread::sleep_for(std::chrono::milliseconds{30});
    }
    EXPECT_EQ(client.ask("OUTP?;:SYST:STAT?"), "1;\"run\"") << bench.log();
}

TEST(ServeTest, WatchdogNeedsRunningOutputLoop) {
    ServiceManager manager;
    ServedBench bench;
    EXPECT_TRUE(manager.hears("WATCHDOG=1", 5));
    manager.forget();
    EXPECT_TRUE(manager.hears("WATCHDOG=1", 1));
    const pid_t output = thread_named(bench.program().pid(), "output");
    ASSERT_GT(output, 0);
    if (ptrace(PTRACE_SEIZE, output, nullptr, nullptr) != 0)
        GTEST_SKIP() << "one thread cannot be stopped here";
    ptrace(PTRACE_INTERRUPT, output, nullptr, nullptr);
    ASSERT_EQ(waitpid(output, nullptr, __WALL), output);
    std::this_thread::sleep_for(std::chrono::milliseconds{700});  // for data gathered before
    manager.forget();
    EXPECT_FALSE(manager.hears("WATCHDOG=1", 2)) << "the drive's loop stands still";
    TcpClient client{bench.scpi_port()};
    EXPECT_EQ(client.ask("*IDN?").substr(0, 7), "shakerd") << "while the rest of it answers";
    ptrace(PTRACE_DETACH, output, nullptr, nullptr);  // a traced process cannot be waited for
    kill(bench.program().pid(), SIGKILL);
}

/// A disk on which one kind of call on these files blocks from after_s until until_s of the program's life.
std::map<std::string, std::string> slow_disk(const char* call, const char* ending, double after_s,
                                             double until_s, const std::filesystem::path& folder) {
    return {{"LD_PRELOAD", test::build_dir() + "/preload_disk_faults.so"},
            {"SHAKER_DISK_FOLDER", std::filesystem::canonical(folder).string()},
            {"SHAKER_DISK_FAULT", std::string{call} + " " + ending + " " + std::to_string(after_s) + " 0 " +
                                      std::to_string(until_s - after_s)}};
}

constexpr const char* quick_run = "phi_rad = 1.745\nperiods = 10\nidentify = false\n";

// Signs of life are due each quarter of a second; a step of the service may come half a second late.
constexpr double longest_silence_s = 0.75;

std::string got(const ServedBench& bench, const std::string& path) {
    TcpClient client{bench.http_port()};
    client.send_bytes("GET " + path + " HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
    return client.rest();
}

/// The state as each door shows it.
void expect_finishing_at_every_door(const ServedBench& bench, ServiceManager& manager,
                                    const std::string& file) {
    EXPECT_NE(got(bench, "/api/state").find("\"state\":\"finishing\""), std::string::npos);
    EXPECT_NE(got(bench, "/metrics").find("shakerd_state{state=\"finishing\"} 1\n"), std::string::npos);
    const std::string at = "--at 127.0.0.1:" + std::to_string(bench.http_port());
    EXPECT_EQ(Program("shakerctl", at + " wait finishing --timeout 1", bench.folder).wait(5).status, 0);
    EXPECT_TRUE(manager.hears("STATUS=finishing " + file, 1));
    EXPECT_TRUE(bench.logged("state: finishing", 1)) << bench.log();
}

TEST(ServeTest, AnswersAndFeedsWatchdogWhileFinishing) {
    if (SHAKER_SANITIZED) GTEST_SKIP() << "a sanitiser cannot be loaded behind another library";
    const auto folder = fresh_folder();
    ServiceManager manager{"2000000"};
    const Environment environment{slow_disk("sync", ".nxs.part", 7, 13, folder)};
    const auto began = Clock::now();
    ServedBench bench{quick_run, folder};
    run_recorded(bench, "long");
    std::this_thread::sleep_until(began + std::chrono::milliseconds{7500});
    manager.forget();
    TcpClient client{bench.scpi_port()};
    client.send("OUTP OFF");
    ASSERT_TRUE(bench.becomes("finishing", 3)) << bench.log();
    expect_finishing_at_every_door(bench, manager, "long.nxs");
    client.send("REC ON,\"next\";:OUTP ON");
    std::string refused = "0,";  // the bench's thread refuses an order with a small delay
    for (int i = 0; i < 40 && refused.starts_with("0,"); ++i) {
        std::this_thread::sleep_for(std::chrono::milliseconds{50});
        refused = client.ask("SYST:ERR?");
    }
    EXPECT_NE(refused.find("still being finished"), std::string::npos) << refused;
    EXPECT_FALSE(std::filesystem::exists(folder / "long.nxs"));
    ASSERT_TRUE(bench.logged("recorded: ", 20)) << bench.log();
    EXPECT_GT(Clock::now() - began, std::chrono::seconds{12}) << "the disk was not slow";
    EXPECT_LT(manager.longest_silence_s(), longest_silence_s) << bench.log();
    EXPECT_TRUE(bench.becomes("idle", 1)) << bench.log();
    client.send("REC ON,\"next\";:OUTP ON");
    EXPECT_TRUE(bench.becomes("run")) << bench.log();
    EXPECT_EQ(client.ask("SYST:ERR?"), "0,\"No error\"");
    EXPECT_EQ(shakerd("recover long.nxs", folder).status, 0) << "a finished file is verified";
}

TEST(ServeTest, ObeysAbortAtOnceWhileFinishing) {
    if (SHAKER_SANITIZED) GTEST_SKIP() << "a sanitiser cannot be loaded behind another library";
    const auto folder = fresh_folder();
    const Environment environment{slow_disk("sync", ".nxs.part", 7, 13, folder)};
    const auto began = Clock::now();
    ServedBench bench{quick_run, folder};
    run_recorded(bench, "long");
    std::this_thread::sleep_until(began + std::chrono::milliseconds{7500});
    TcpClient client{bench.scpi_port()};
    client.send("OUTP OFF");
    ASSERT_TRUE(bench.becomes("finishing", 3)) << bench.log();
    const auto ordered = Clock::now();
    client.send("ABOR");
    ASSERT_TRUE(bench.becomes("tripped", 1)) << bench.log();
    EXPECT_LT(Clock::now() - ordered, std::chrono::milliseconds{300});
    EXPECT_EQ(client.ask("REC:FIN?"), "1") << "the recording goes on to be finished";
    ASSERT_TRUE(bench.logged("recorded: ", 20)) << bench.log();
    EXPECT_EQ(client.ask("SYST:STAT?"), "\"tripped\"");
    EXPECT_EQ(shakerd("recover long.nxs", folder).status, 0) << "a finished file is verified";
}

TEST(ServeTest, DrivesOnWhileDiskQueryHangs) {
    if (SHAKER_SANITIZED) GTEST_SKIP() << "a sanitiser cannot be loaded behind another library";
    const auto folder = fresh_folder();
    ServiceManager manager{"2000000"};
    const Environment environment{slow_disk("space", "*", 7, 11, folder)};
    const auto began = Clock::now();
    ServedBench bench{quick_run, folder};
    TcpClient client{bench.scpi_port()};
    client.send("OUTP ON");
    ASSERT_TRUE(bench.becomes("run")) << bench.log();
    manager.forget();
    std::this_thread::sleep_until(began + std::chrono::milliseconds{11500});
    EXPECT_EQ(client.ask("SYST:STAT?"), "\"run\"") << bench.log();
    EXPECT_LT(manager.longest_silence_s(), longest_silence_s) << bench.log();
}

TEST(ServeTest, DrivesAndStopsWhileRecorderHangs) {
    if (SHAKER_SANITIZED) GTEST_SKIP() << "a sanitiser cannot be loaded behind another library";
    const auto folder = fresh_folder();
    ServiceManager manager{"2000000"};
    const Environment environment{slow_disk("any", "*", 7, 13, folder)};
    const auto began = Clock::now();
    ServedBench bench{quick_run, folder};
    run_recorded(bench, "long");
    std::this_thread::sleep_until(began + std::chrono::milliseconds{7500});
    manager.forget();
    std::this_thread::sleep_until(began + std::chrono::milliseconds{9500});
    TcpClient client{bench.scpi_port()};
    EXPECT_EQ(client.ask("SYST:STAT?"), "\"run\"") << bench.log();
    client.send("OUTP OFF");
    ASSERT_TRUE(bench.becomes("finishing", 3)) << bench.log();
    EXPECT_EQ(client.ask("REC:FIN?"), "1");
    EXPECT_LT(Clock::now() - began, std::chrono::seconds{13}) << "the disk hangs no longer";
    ASSERT_TRUE(bench.logged("recorded: ", 20)) << bench.log();
    EXPECT_LT(manager.longest_silence_s(), longest_silence_s) << bench.log();
    EXPECT_EQ(client.ask("REC:FIN?"), "0");
    EXPECT_EQ(shakerd("recover long.nxs", folder).status, 0) << "no data were lost";
}

TEST(ServeTest, ReloadWithoutSettingsReadsNothing) {
    test::Program program{"shakerd", "serve --http-port 0 --scpi-port 0 --recordings .", fresh_folder()};
    const auto logged = [&](const char* words) {
        for (const auto end = Clock::now() + std::chrono::seconds{30}; Clock::now() < end;) {
            std::ifstream in{program.said()};
            const std::string log{std::istreambuf_iterator<char>{in}, {}};
            if (log.find(words) != std::string::npos) return true;
            std::this_thread::sleep_for(std::chrono::milliseconds{20});
        }
        return false;
    };
    ASSERT_TRUE(logged("state: idle"));
    kill(program.pid(), SIGHUP);
    EXPECT_TRUE(logged("nothing was read: the daemon was started without --settings FILE"));
}

TEST(ServeTest, ReloadTakesAllSettingsOrNone) {
    ServedBench bench;
    TcpClient client{bench.scpi_port()};
    bench.settings("phi_rad = 0.5\ngamma_mps2 = 5\nperiods = 30\n");
    kill(bench.program().pid(), SIGHUP);
    EXPECT_TRUE(bench.logged("settings reloaded: ")) << "names the files";
    EXPECT_TRUE(bench.logged(" and the limits in ")) << bench.log();
    EXPECT_EQ(client.ask("ACC?;:BIH:PHAS?"), "5.00000000E+00;5.00000000E-01");

    bench.settings("phi_rad = 1\ngamma_mps2 = 5000\n");
    kill(bench.program().pid(), SIGHUP);
    EXPECT_TRUE(bench.logged("gamma_mps2: expected a number")) << bench.log();
    EXPECT_EQ(client.ask("ACC?;:BIH:PHAS?"), "5.00000000E+00;5.00000000E-01");

    bench.settings("phi_rad = 1\nframes = \"full\"\n");
    kill(bench.program().pid(), SIGHUP);
    EXPECT_TRUE(bench.logged("frames was changed; restart the daemon")) << bench.log();

    bench.settings("phi_rad = 1.745\nperiods = 10\n");
    client.send("OUTP ON");
    EXPECT_TRUE(bench.becomes("run")) << bench.log();
    kill(bench.program().pid(), SIGHUP);
    EXPECT_TRUE(bench.logged("stop the drive first")) << bench.log();
    EXPECT_EQ(client.ask("ACC?;:BIH:PHAS?"), "5.00000000E+00;5.00000000E-01");
}

}  // namespace
}  // namespace shaker::test
