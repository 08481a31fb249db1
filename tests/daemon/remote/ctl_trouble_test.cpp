#include <gtest/gtest.h>

#include <chrono>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "daemon/remote/ctl/link.hpp"
#include "daemon/remote/ctl/outcome.hpp"
#include "daemon/remote/server.hpp"
#include "drivers/errors.hpp"
#include "tests/support/environment.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/program.hpp"
#include "tests/support/remote/canned_daemon.hpp"
#include "tests/support/remote/played_bench.hpp"

namespace shaker::ctl {
namespace {

using test::CannedDaemon;
using test::Environment;
using test::http_answer;
using test::Outcome;
using test::PlayedBench;

constexpr double limit_s = 30;

Outcome ctl(const std::string& arguments) {
    return test::Program{"shakerctl", arguments, test::fresh_folder()}.wait(limit_s);
}

Outcome ctl_at(int port, const std::string& arguments) {
    return ctl("--at 127.0.0.1:" + std::to_string(port) + " " + arguments);
}

int port_of_nobody() { return CannedDaemon{""}.port(); }

TEST(CtlTroubleTest, MissingDaemonIsStatus69ForEveryCommand) {
    const int port = port_of_nobody();
    for (const char* command : {"status", "set --rho 0.5", "identify", "start", "middle", "mu 0.1", "stop",
                                "abort", "clear", "record off", "watch", "fetch state", "fetch result",
                                "fetch points", "fetch metrics", "wait idle"}) {
        const Outcome failed = ctl_at(port, command);
        EXPECT_EQ(failed.status, exit_not_reached) << command;
        EXPECT_NE(failed.err.find("127.0.0.1:" + std::to_string(port) + ": Connection refused"),
                  std::string::npos)
            << failed.err;
    }
}

TEST(CtlTroubleTest, WaitAllowsDaemonToStart) {
    const int port = port_of_nobody();
    test::Program waits{"shakerctl", "--at 127.0.0.1:" + std::to_string(port) + " wait idle",
                        test::fresh_folder()};
    std::this_thread::sleep_for(std::chrono::milliseconds{700});
    EXPECT_FALSE(waits.ended());
    test::PlayedBench bench;
    const remote::Server late{bench.bench_port, {.http_port = port, .scpi_port = 0}};
    EXPECT_EQ(waits.wait(limit_s).status, exit_done);
}

TEST(CtlTroubleTest, FailedAbortPointsToEmergencyStop) {
    EXPECT_NE(ctl_at(port_of_nobody(), "abort").err.find("use the emergency stop"), std::string::npos);
    const CannedDaemon stranger{http_answer("404 Not Found", "<html>nothing here</html>")};
    const Outcome failed = ctl_at(stranger.port(), "abort");
    EXPECT_EQ(failed.status, exit_not_reached);
    EXPECT_NE(failed.err.find("use the emergency stop"), std::string::npos) << failed.err;
}

TEST(CtlTroubleTest, SilentDaemonTimesOutAfter5sAbortAfter2s) {
    const CannedDaemon silent{""};
    const auto taken = [&](const std::string& command) {
        const auto begin = std::chrono::steady_clock::now();
        const Outcome left = ctl_at(silent.port(), command);
        EXPECT_EQ(left.status, exit_not_reached) << command;
        EXPECT_NE(left.err.find("no answer in time"), std::string::npos) << left.err;
        const std::chrono::duration<double> lasted = std::chrono::steady_clock::now() - begin;
        std::printf("%s: %.2f s, of which %.2f s on a processor\n", command.c_str(), lasted.count(),
                    left.cpu_s);
        return lasted.count();
    };
    EXPECT_NEAR(taken("status"), 5, 1);
    EXPECT_NEAR(taken("watch"), 5, 1);
    EXPECT_NEAR(taken("abort"), 2, 1);
}

// Its user must know at once that the shaker is not stopped.
TEST(CtlTroubleTest, NameServerThatIsSilentDoesNotDelayAnAbort) {
    const Environment slow{{{"LD_PRELOAD", test::build_dir() + "/preload_slow_names.so"}}};
    const auto begin = std::chrono::steady_clock::now();
    const Outcome left = ctl("--at silent.test:1 abort");
    const std::chrono::duration<double> lasted = std::chrono::steady_clock::now() - begin;
    EXPECT_EQ(left.status, exit_not_reached);
    EXPECT_NE(left.err.find("the address of \"silent.test\" was not found in time"), std::string::npos)
        << left.err;
    EXPECT_NEAR(lasted.count(), 2, 1);
}

TEST(CtlTroubleTest, OtherServerIsReported) {
    const std::string bodies[] = {"<html>hello</html>", "", "[1,2]", "\"ok\"", "{\"ok\":"};
    for (const std::string& body : bodies) {
        const CannedDaemon stranger{http_answer("200 OK", body)};
        for (const char* command : {"status", "start", "watch", "wait idle", "fetch result"}) {
            const Outcome failed = ctl_at(stranger.port(), command);
            EXPECT_EQ(failed.status, exit_not_reached) << command << " " << body << failed.err;
        }
    }
    const CannedDaemon babbler{std::string(100000, 'x')};
    EXPECT_EQ(ctl_at(babbler.port(), "status").status, exit_not_reached);
    const CannedDaemon hasty{"HTTP/1.1 200 OK\r\nContent-Length: 10\r\n\r\n{"};
    EXPECT_EQ(ctl_at(hasty.port(), "status").status, exit_not_reached);
}

TEST(CtlTroubleTest, ControlSequencesAreEscaped) {
    const CannedDaemon state{http_answer(
        "200 OK",
        R"({"session":{"state":"\u001b[2Jidle","rig":"a\nb\u202ec","trip":{"text":"\u009b31m"}},"losses":7})")};
    const Outcome words = ctl_at(state.port(), "status");
    EXPECT_EQ(words.status, exit_done) << words.err;
    EXPECT_NE(words.out.find("state      \\x1b[2Jidle,"), std::string::npos) << words.out;
    EXPECT_NE(words.out.find("rig        a\\x0ab\\u202ec,"), std::string::npos) << words.out;
    EXPECT_NE(words.out.find("stopped    \\u009b31m"), std::string::npos) << words.out;
    for (const char* how : {"status --json", "fetch state"}) {
        const std::string whole = ctl_at(state.port(), how).out;
        EXPECT_EQ(whole.find_first_of("\x1b\xc2\xe2"), std::string::npos) << whole;
        EXPECT_EQ(nlohmann::json::parse(whole)["session"]["state"], "\x1b[2Jidle");
    }
    const CannedDaemon refuses{http_answer("409 Conflict", R"({"error":"no \u001b]0;you\u0007 \r not"})")};
    EXPECT_EQ(ctl_at(refuses.port(), "start").err, "shakerctl: no \\x1b]0;you\\x07 \\x0d not\n");
    const CannedDaemon metrics{http_answer("200 OK", "a 1\nb\x1b 2\n")};
    EXPECT_EQ(ctl_at(metrics.port(), "fetch metrics").out, "a 1\nb\\x1b 2\n");
}

TEST(CtlTroubleTest, NewestMeasurementIsPrintedUnchanged) {
    const std::string result =
        R"({"cycle":{"phase":[0.0,0.5],"v_mps":[1e-3,-0.25]},"v_D_mps":{"sigma":3e-05,"value":0.0145}})";
    const CannedDaemon daemon{http_answer("200 OK", result)};
    EXPECT_EQ(nlohmann::json::parse(ctl_at(daemon.port(), "fetch result").out),
              nlohmann::json::parse(result));
}

TEST(CtlTroubleTest, WrongValuesAreRefusedWithRange) {
    const int port = port_of_nobody();
    const auto refused = [&](const std::string& words) {
        const Outcome outcome = ctl_at(port, words);
        EXPECT_EQ(outcome.status, exit_wrong_use) << words;
        return outcome.err;
    };
    for (const char* words : {"set --gamma '3 bananas'", "set --gamma 3 bananas"}) {
        const std::string bananas = refused(words);
        EXPECT_NE(bananas.find("--gamma \"3 bananas\""), std::string::npos) << bananas;
        EXPECT_NE(bananas.find("allowed: 0.01 to 980"), std::string::npos) << bananas;
    }
    EXPECT_NE(refused("set --gamma 1.5 g").find("needs quotes: \"1.5 g\""), std::string::npos);
    EXPECT_NE(refused("set --rho 1.5").find("--rho \"1.5\": out of range"), std::string::npos);
    EXPECT_NE(refused("set --frequency nan").find("--frequency \"nan\": expected a finite number"),
              std::string::npos);
    EXPECT_NE(refused("set").find("expected --gamma, --phi, --rho or --frequency"), std::string::npos);
    EXPECT_NE(refused("start --periods 1").find("--periods \"1\": expected a whole number from 3 to 1000000"),
              std::string::npos);
    EXPECT_NE(refused("start --periods 2.5").find("--periods \"2.5\": expected a whole number from 3"),
              std::string::npos);
    EXPECT_NE(refused("wait runing").find("STATE \"runing\": expected one of starting, idle"),
              std::string::npos);
    EXPECT_NE(refused("wait idle --timeout -1").find("--timeout \"-1\": out of range"), std::string::npos);
    EXPECT_NE(refused("record maybe").find("SWITCH \"maybe\": expected one of on, off"), std::string::npos);
    EXPECT_NE(refused("record on --frames some")
                  .find("--frames \"some\": expected one of off, first-second, region, full"),
              std::string::npos);
    EXPECT_NE(refused("fetch").find("WHAT is required"), std::string::npos);
    EXPECT_NE(refused("dance"), "");
    EXPECT_NE(refused(""), "");
    EXPECT_NE(refused("status $'\\x1b[31m'").find("\\x1b[31m"), std::string::npos) << "by bash";
}

TEST(CtlTroubleTest, AddressesAcceptCommonForms) {
    EXPECT_EQ(address_of("--at", "http://127.0.0.1:8080").text(), "127.0.0.1:8080");
    EXPECT_EQ(address_of("--at", "http://bench.lab/").text(), "bench.lab:8080");
    EXPECT_EQ(address_of("--at", "bench:80").text(), "bench:80");
    EXPECT_EQ(address_of("--at", "http://[::1]:81").text(), "[::1]:81");
    EXPECT_EQ(address_of("--at", "[::1]").host, "::1");
    for (const char* wrong :
         {"", "http://", "https://bench", "ftp://bench", "bench:0", "bench:65536", "bench:8o",
          "bench:", "::1", "[::1", "[::1]8", "[bench]", "a b", "bench\r\nX: y", "bench/page", "user@bench"})
        EXPECT_THROW(address_of("--at", wrong), InputError) << wrong;
    try {
        address_of("SHAKERD_URL", "bench:99999");
    } catch (const InputError& e) {
        EXPECT_NE(std::string{e.what()}.find("SHAKERD_URL \"bench:99999\": port 1 to 65535"),
                  std::string::npos)
            << e.what();
    }
}

TEST(CtlTroubleTest, FullDiskIsReported) {
    const auto folder = test::fresh_folder();
    EXPECT_EQ((test::Program{"shakerctl", "manual >/dev/full 2>said; true", folder}.wait(limit_s).status),
              exit_not_written);
    std::string said;
    std::getline(std::ifstream{folder / "said"}, said);
    EXPECT_EQ(said, "shakerctl: standard output: No space left on device");
}

struct CtlTokenTest : testing::Test {
    const std::string token = "0123456789abcdefghijklmn";
    PlayedBench bench;
    remote::Server server{bench.bench_port, {.http_port = 0, .scpi_port = 0, .token = token}};
    std::filesystem::path folder = test::fresh_folder();
    Environment url{{{"SHAKERD_URL", "http://localhost:" + std::to_string(server.http_port()) + "/"}}};

    [[nodiscard]] Outcome with_file(const std::string& content, std::filesystem::perms mode) const {
        const auto file = folder / "token";
        std::ofstream{file} << content;
        std::filesystem::permissions(file, mode);
        return test::Program{"shakerctl", "abort --token-file token", folder}.wait(limit_s);
    }
};

TEST_F(CtlTokenTest, EveryRequestButAbortNeedsToken) {
    for (const char* command : {"status", "start", "watch", "wait idle", "fetch metrics"}) {
        const Outcome refused = ctl(command);
        EXPECT_EQ(refused.status, exit_refused) << command;
        EXPECT_NE(refused.err.find("a token is required"), std::string::npos) << command << refused.err;
    }
    EXPECT_EQ(ctl("abort").status, exit_done);
    EXPECT_EQ(bench.aborts, 1);
}

TEST_F(CtlTokenTest, AbortThatIsNotObeyedFails) {
    bench.hung = true;
    const Outcome aborted = ctl("abort");
    EXPECT_EQ(aborted.status, exit_refused);
    EXPECT_EQ(aborted.out, "");
    EXPECT_NE(aborted.err.find("the output does not answer: cut the amplifier"), std::string::npos)
        << aborted.err;
    EXPECT_EQ(bench.aborts, 1);
}

TEST_F(CtlTokenTest, TokenFromEnvironmentIsAccepted) {
    const Environment set{{{"SHAKERD_TOKEN", token}}};
    for (const char* command : {"status", "wait idle", "watch --seconds 0.2", "abort"})
        EXPECT_EQ(ctl(command).status, exit_done) << command;
    EXPECT_EQ(bench.aborts, 1);
}

TEST_F(CtlTokenTest, TokenFileIsPrivateAndPrecedesEnvironment) {
    using std::filesystem::perms;
    const perms own = perms::owner_read | perms::owner_write;
    const Environment set{{{"SHAKERD_TOKEN", "another"}}};
    EXPECT_EQ(with_file(token + "\n", own).status, exit_done);
    EXPECT_EQ(bench.aborts, 1);
    const Outcome open = with_file(token, own | perms::group_read);
    EXPECT_EQ(open.status, exit_wrong_use);
    EXPECT_NE(open.err.find("--token-file token: other users can read it (mode 640); set mode 600"),
              std::string::npos)
        << open.err;
    EXPECT_EQ(with_file("", own).status, exit_wrong_use);
    EXPECT_EQ(with_file("tok\x01"
                        "en",
                        own)
                  .status,
              exit_wrong_use);
    std::filesystem::remove(folder / "token");
    EXPECT_EQ(ctl("abort --token-file token").status, exit_wrong_use);
    EXPECT_EQ(bench.aborts, 1);
}

}  // namespace
}  // namespace shaker::ctl
