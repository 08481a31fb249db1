// A disk that takes seconds a call, and a system that grants no thread: the control goes on and feeds the
// watchdog in every state, and nothing that was measured is lost.
#include <gtest/gtest.h>
#include <spdlog/fmt/fmt.h>

#include <csignal>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>

#include "tests/support/environment.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/remote/served_bench.hpp"
#include "tests/support/remote/service_manager.hpp"

namespace shaker::test {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;

// Signs of life are due each quarter of a second.
constexpr double longest_silence_s = 0.5;
constexpr const char* run = "phi_rad = 1.745\nperiods = 10\nidentify = false\n";

class SlowCallsTest : public testing::Test {
protected:
    void SetUp() override {
        if (SHAKER_SANITIZED) GTEST_SKIP() << "a sanitiser cannot be loaded behind another library";
    }
    /// slow_s: time of a call of the disk; 0: no thread is granted instead.
    void serve(const char* slow_s) {
        environment_.emplace(std::map<std::string, std::string>{
            {"LD_PRELOAD", build_dir() + "/preload_slow_calls.so"},
            {"SHAKER_DISK_FOLDER", std::filesystem::canonical(folder_).string()},
            {"SHAKER_TROUBLE", trouble_.string()},
            {"SHAKER_SLOW_S", slow_s}});
        bench_.emplace(run, folder_);
        client_.emplace(bench_->scpi_port());
        ASSERT_TRUE(bench_->becomes("idle")) << bench_->log();
    }
    void begin_trouble() const { std::ofstream{trouble_} << "now"; }
    json state() {
        TcpClient http{bench_->http_port()};
        http.send_bytes("GET /api/state HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
        const std::string answer = http.rest();
        return json::parse(answer.substr(answer.find("\r\n\r\n") + 4));
    }
    std::string posted(const std::string& action, const json& body) {
        TcpClient http{bench_->http_port()};
        const std::string text = body.dump();
        http.send_bytes(
            fmt::format("POST /api/{} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n"
                        "Content-Length: {}\r\n\r\n{}",
                        action, text.size(), text));
        return http.rest();
    }
    template <class When>
    bool until(When when, double limit_s = 40) {
        for (double s = 0; s < limit_s; s += 0.05) {
            if (when(state())) return true;
            std::this_thread::sleep_for(50ms);
        }
        return false;
    }
    // Queries by SCPI wait for the order before them.
    static bool armed(const json& s) { return s["session"]["state"] == "armed"; }
    void expect_alive(const char* after) {
        EXPECT_LT(manager_.longest_silence_s(), longest_silence_s) << after << "\n" << bench_->log();
        manager_.forget();
    }

    std::filesystem::path folder_ = fresh_folder(), trouble_ = fresh_folder() / "trouble";
    ServiceManager manager_{"2000000"};
    std::optional<Environment> environment_;
    std::optional<ServedBench> bench_;
    std::optional<TcpClient> client_;
};

TEST_F(SlowCallsTest, DiskOfSecondsKeepsNoHeartbeat) {
    serve("3");
    begin_trouble();
    manager_.forget();
    client_->send("REC ON,\"slow\";:TRIG:COUN 1;:OUTP ON");
    EXPECT_TRUE(until(armed, 5)) << "its file is being opened\n" << bench_->log();
    ASSERT_TRUE(bench_->becomes("run", 40)) << bench_->log();
    expect_alive("start of a recorded run");
    EXPECT_EQ(client_->ask("SYST:ERR?"), "0,\"No error\"");
    std::filesystem::remove(trouble_);
    ASSERT_TRUE(bench_->becomes("idle", 60)) << bench_->log();
    EXPECT_TRUE(std::filesystem::exists(folder_ / "slow.nxs"));
    begin_trouble();
    manager_.forget();
    const std::string begun =
        posted("campaign", {{"scan", "phi"}, {"from", 1.7}, {"to", 1.8}, {"steps", 1}, {"periods", 5}});
    ASSERT_TRUE(until([](const json& s) { return !s["campaign"].is_null(); })) << begun << bench_->log();
    expect_alive("start of a campaign");
    ASSERT_TRUE(bench_->logged("point 1 of 2", 60)) << bench_->log();
    expect_alive("first point of a campaign");
}

TEST_F(SlowCallsTest, StopBeforeTheFileIsOpenStartsNothing) {
    serve("3");
    begin_trouble();
    client_->send("REC ON,\"never\";:OUTP ON");
    ASSERT_TRUE(until(armed, 5)) << bench_->log();
    EXPECT_NE(posted("stop", json::object()).find("200 OK"), std::string::npos);
    EXPECT_TRUE(until([](const json& s) { return s["session"]["state"] == "idle"; }, 1)) << bench_->log();
    std::this_thread::sleep_for(7s);
    EXPECT_EQ(bench_->log().find("loop_check"), std::string::npos) << bench_->log();
    EXPECT_FALSE(std::filesystem::exists(folder_ / "never.nxs"));
    EXPECT_TRUE(bench_->becomes("idle", 1));
}

TEST_F(SlowCallsTest, AbortBeforeTheFileIsOpenIsShownAtOnce) {
    serve("3");
    begin_trouble();
    client_->send("REC ON,\"never\";:OUTP ON");
    ASSERT_TRUE(until(armed, 5)) << bench_->log();
    EXPECT_NE(posted("abort", json::object()).find("200 OK"), std::string::npos);
    EXPECT_TRUE(until([](const json& s) { return s["session"]["state"] == "tripped"; }, 1)) << bench_->log();
    EXPECT_EQ(bench_->log().find("loop_check"), std::string::npos) << bench_->log();
}

TEST_F(SlowCallsTest, NoThreadEndsNoRun) {
    serve("0");
    client_->send("REC ON,\"poor\";:TRIG:COUN 2;:OUTP ON");
    ASSERT_TRUE(bench_->becomes("run")) << bench_->log();
    begin_trouble();
    ASSERT_TRUE(until([](const json& s) { return s["result"]["number"] == 2; })) << bench_->log();
    ASSERT_TRUE(bench_->becomes("idle")) << bench_->log();
    EXPECT_TRUE(std::filesystem::exists(folder_ / "poor.nxs"));
    posted("campaign/check", {{"scan", "phi"}, {"from", 0}, {"to", 1}, {"steps", 2}, {"periods", 5}});
    TcpClient law{bench_->http_port()};
    law.send_bytes("GET /api/law HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
    law.rest();
    EXPECT_TRUE(bench_->becomes("idle", 1)) << "the daemon goes on: " << bench_->log();
    std::filesystem::remove(trouble_);
    EXPECT_NE(
        posted("campaign/check", {{"scan", "phi"}, {"from", 0}, {"to", 1}, {"steps", 2}, {"periods", 5}})
            .find("200 OK"),
        std::string::npos)
        << "a thread is granted again";
}

// The largest plan is answered at once, and SIGTERM ends its check.
TEST_F(SlowCallsTest, LargestPlanHoldsUpNothing) {
    serve("0");
    manager_.forget();
    const json largest{{"scan", "phi"}, {"from", 0}, {"to", 6}, {"steps", 1000}, {"repeats", 9}};
    EXPECT_NE(posted("campaign/check", largest).find("200 OK"), std::string::npos) << bench_->log();
    expect_alive("check of 9009 points");
    const auto asked = std::chrono::steady_clock::now();
    kill(bench_->program().pid(), SIGTERM);
    EXPECT_EQ(bench_->program().wait(20).status, 0);
    EXPECT_LT(std::chrono::steady_clock::now() - asked, 5s);
}

}  // namespace
}  // namespace shaker::test
