#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "daemon/remote/ctl/outcome.hpp"
#include "daemon/remote/server.hpp"
#include "tests/support/program.hpp"
#include "tests/support/remote/played_bench.hpp"
#include "tests/support/remote/tcp_client.hpp"

namespace shaker::ctl {
namespace {

using nlohmann::json;
using test::Outcome;
using test::PlayedBench;
using test::Program;
using Clock = std::chrono::steady_clock;

constexpr double limit_s = 30;

struct CtlTest : testing::Test {
    PlayedBench bench;
    remote::Server server{bench.bench_port, {.http_port = 0, .scpi_port = 0}};
    std::filesystem::path folder = test::fresh_folder();

    [[nodiscard]] std::string words(const std::string& arguments) const {
        return "--at http://127.0.0.1:" + std::to_string(server.http_port()) + " " + arguments;
    }
    [[nodiscard]] Outcome ctl(const std::string& arguments) const {
        return Program{"shakerctl", words(arguments), folder}.wait(limit_s);
    }
    template <class Order>
    [[nodiscard]] Order last() const {
        const auto all = bench.ordered();
        return all.empty() ? Order{} : std::get<Order>(all.back());
    }
    // Takes control as an open page does.
    void take_control(test::TcpClient& page) const {
        const std::string who = " HTTP/1.1\r\nHost: localhost\r\nX-Shaker-Client: tab1\r\n";
        page.send_bytes("GET /ws" + who +
                        "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
                        "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n");
        ASSERT_NE(page.until("\r\n\r\n").find(" 101 "), std::string::npos);
        test::TcpClient asks{server.http_port()};
        asks.send_bytes("POST /api/control/request" + who + "Connection: close\r\nContent-Length: 0\r\n\r\n");
        ASSERT_NE(asks.rest().find("200 OK"), std::string::npos);
    }
    // Waits until a client watches over a WebSocket; the client receives events only from then on.
    [[nodiscard]] bool watched() const {
        for (int i = 0; i < 1000; ++i) {
            test::TcpClient client{server.http_port()};
            client.send_bytes("GET /metrics HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
            // This request counts as a client too.
            if (client.rest().find("shakerd_clients{kind=\"web\"} 2\n") != std::string::npos) return true;
            std::this_thread::sleep_for(std::chrono::milliseconds{5});
        }
        return false;
    }
};

std::vector<std::string> lines_of(const std::string& text) {
    std::vector<std::string> lines;
    std::istringstream in{text};
    for (std::string line; std::getline(in, line);) lines.push_back(line);
    return lines;
}

TEST_F(CtlTest, StatusPrintsTextOrOneLineOfJson) {
    const Outcome words = ctl("status");
    EXPECT_EQ(words.status, exit_done) << words.err;
    EXPECT_EQ(words.out.substr(0, 16), "state      idle,") << words.out;
    EXPECT_NE(words.out.find("drive      20 Hz, gamma 9.8 m/s^2 (1 g), rho 0.5, phi 0 rad (0 deg)\n"),
              std::string::npos)
        << words.out;
    EXPECT_NE(words.out.find("control    free\n"), std::string::npos) << words.out;
    const Outcome whole = ctl("status --json");
    EXPECT_EQ(lines_of(whole.out).size(), 1U);
    EXPECT_EQ(json::parse(whole.out)["session"]["rig"], "played");
}

TEST_F(CtlTest, SetChangesOnlyGivenValues) {
    ASSERT_EQ(ctl("set --gamma 1.5g --phi -30deg --rho 40% --frequency 25Hz").status, exit_done);
    Drive drive = last<service::SetDrive>().drive;
    EXPECT_DOUBLE_EQ(drive.gamma, 14.7);
    EXPECT_DOUBLE_EQ(drive.phi, -std::numbers::pi / 6);
    EXPECT_DOUBLE_EQ(drive.rho, 0.4);
    EXPECT_DOUBLE_EQ(drive.frequency, 25);
    ASSERT_EQ(ctl("set --gamma 2").status, exit_done);
    drive = last<service::SetDrive>().drive;
    EXPECT_DOUBLE_EQ(drive.gamma, 2);
    EXPECT_DOUBLE_EQ(drive.frequency, 25);
}

TEST_F(CtlTest, RefusalIsStatus1WithReason) {
    const Outcome refused = ctl("set --gamma 20g");
    EXPECT_EQ(refused.status, exit_refused);
    EXPECT_EQ(refused.err, "shakerctl: acceleration 120 m/s^2: at most 50 is allowed\n");
    EXPECT_EQ(refused.out, "");
}

TEST_F(CtlTest, StartWaitsForAMeasurementAndStopForSilence) {
    EXPECT_EQ(ctl("start").status, exit_done);
    EXPECT_EQ(last<service::Begin>().plan.periods, 40) << "default of the daemon";
    EXPECT_EQ(ctl("stop --wait").status, exit_done);
    const Outcome started = ctl("start --periods 12 --settle 7 --wait");
    EXPECT_EQ(started.status, exit_done) << started.err;
    EXPECT_EQ(started.out, "v_D 14.500 +- 0.030 mm/s\n");
    EXPECT_EQ(last<service::Begin>().plan.periods, 12);
    EXPECT_EQ(last<service::Begin>().plan.settle, 7);
    EXPECT_EQ(ctl("start").status, exit_refused);
    EXPECT_NE(ctl("status").out.find("v_D 14.500 +- 0.030 mm/s, D 0.7250 +- 0.0015 mm"), std::string::npos);
    EXPECT_EQ(ctl("stop --wait").status, exit_done);
    EXPECT_EQ(bench.bench_port.state()->state, run::RunState::idle);
    EXPECT_EQ(ctl("start").status, exit_done) << "without --wait and --periods";
    EXPECT_EQ(last<service::Begin>().plan.periods, 12) << "as last";
    EXPECT_EQ(last<service::Begin>().plan.settle, 7) << "as last";
    EXPECT_EQ(ctl("stop").status, exit_done);
    EXPECT_EQ(ctl("remark 'new paper'").status, exit_done);
    EXPECT_EQ(last<service::Remark>().text, "new paper");
}

TEST_F(CtlTest, IdentifyClearAndRecordAreOrders) {
    EXPECT_EQ(ctl("identify").status, exit_done);
    EXPECT_TRUE(std::holds_alternative<service::Identify>(bench.ordered().back()));
    EXPECT_EQ(ctl("record on --name series-1 --frames full").status, exit_done);
    service::Record record = last<service::Record>();
    EXPECT_TRUE(record.on);
    EXPECT_EQ(record.name, "series-1");
    EXPECT_EQ(record.pictures, recorded::KeptPictures::full);
    EXPECT_EQ(ctl("record off").status, exit_done);
    record = last<service::Record>();
    EXPECT_FALSE(record.on);
    EXPECT_EQ(record.name, "");
    EXPECT_EQ(ctl("middle --wait").status, exit_done);
    EXPECT_TRUE(std::holds_alternative<service::BringToMiddle>(bench.ordered().back()));
    EXPECT_EQ(ctl("reset-walker").status, exit_done);
    EXPECT_TRUE(std::holds_alternative<service::PutWalkerBack>(bench.ordered().back()));
    EXPECT_EQ(ctl("mu 0.12 --error 0.01").status, exit_done);
    EXPECT_EQ(last<service::GiveMu>().mu.value, 0.12);
    EXPECT_EQ(last<service::GiveMu>().mu.sigma, 0.01);
    EXPECT_EQ(ctl("targets --camera top --target walker --region 40,20,180,170").status, exit_done);
    const auto moved = last<service::MoveTargets>().targets.at(0);
    EXPECT_EQ(text(moved), "camera \"top\", target \"walker\", roi_px = [40, 20, 180, 170]");
    EXPECT_EQ(ctl("targets --camera top --target walker").status, exit_wrong_use);
    const Outcome odd = ctl("targets --camera top --target walker --region 40,x");
    EXPECT_EQ(odd.status, exit_refused);
    EXPECT_NE(odd.err.find("region_px: expected four numbers x, y, width, height"), std::string::npos)
        << odd.err;
    EXPECT_EQ(ctl("clear").status, exit_done);
    EXPECT_TRUE(std::holds_alternative<service::ClearTrip>(bench.ordered().back()));
}

// The output clears a trip a moment after the order was accepted.
TEST_F(CtlTest, ClearWaitsUntilTheTripIsGone) {
    bench.clears_after = 200;  // steps of 1 ms
    EXPECT_EQ(ctl("abort").status, exit_done);
    const Outcome cleared = ctl("clear");
    EXPECT_EQ(cleared.status, exit_done) << cleared.err;
    EXPECT_EQ(ctl("status").out.substr(0, 16), "state      idle,");
}

TEST_F(CtlTest, CampaignsAreOrderedByName) {
    EXPECT_EQ(ctl("campaign plans").out, "fig3\nmu\n");
    EXPECT_EQ(ctl("campaign start --plan nothing").status, exit_refused);
    const Outcome measured = ctl("campaign start --plan fig3 --wait");
    EXPECT_EQ(measured.status, exit_done) << measured.err;
    EXPECT_EQ(measured.out, "12 of 12 points have ended; folder fig3-x\n");
    EXPECT_EQ(last<service::MeasurePlan>().name, "fig3");
    EXPECT_EQ(ctl("campaign pause").status, exit_done);
    EXPECT_EQ(last<service::TellCampaign>().word, campaign::Word::pause);
    EXPECT_EQ(ctl("campaign check --plan mu").out, "12 points\n");
    const Outcome misfit = ctl("campaign check --plan fig3");
    EXPECT_EQ(misfit.status, exit_refused);
    EXPECT_EQ(misfit.out, "point 3 does not fit: its way is too long\n12 points\n");
    EXPECT_EQ(misfit.err, "shakerctl: 1 of 12 points do not fit\n");
    for (const char* wrong :
         {"campaign start", "campaign check", "campaign pause --plan fig3", "campaign go"})
        EXPECT_EQ(ctl(wrong).status, exit_wrong_use) << wrong;
}

TEST_F(CtlTest, RefusalNamesHolderAndAbortWorksAnyway) {
    test::TcpClient page{server.http_port()};
    take_control(page);
    for (const char* order : {"set --gamma 1g", "identify", "start", "start --wait", "stop", "stop --wait",
                              "middle", "reset-walker", "mu 0.1", "clear", "record on",
                              "targets --camera top --target walker --region 1,2,3,4"}) {
        const Outcome refused = ctl(order);
        EXPECT_EQ(refused.status, exit_refused) << order;
        EXPECT_TRUE(
            refused.err.starts_with("shakerctl: control is held by page tab1 at 127.0.0.1; release it"))
            << order << refused.err;
    }
    EXPECT_TRUE(bench.ordered().empty());
    EXPECT_NE(ctl("status").out.find("control    held by page tab1 at 127.0.0.1\n"), std::string::npos);
    EXPECT_EQ(ctl("abort").status, exit_done);
    EXPECT_EQ(bench.aborts, 1);
}

TEST_F(CtlTest, AbortWorksWhileBenchDoesNotAnswer) {
    bench.deaf = true;
    Program waits{"shakerctl", words("start"), folder};
    while (bench.bench_port.ordered() == 0) std::this_thread::sleep_for(std::chrono::milliseconds{1});
    const auto begin = Clock::now();
    const Outcome aborted = ctl("abort");
    EXPECT_LT(Clock::now() - begin, std::chrono::seconds{1});
    EXPECT_EQ(aborted.status, exit_done) << aborted.err;
    EXPECT_EQ(aborted.out, "aborted\n");
    EXPECT_EQ(bench.aborts, 1);
    bench.deaf = false;
    EXPECT_EQ(waits.wait(limit_s).status, exit_refused) << "the command was waiting at the abort";
}

TEST_F(CtlTest, UnansweredOrderEndsAfterFiveSeconds) {
    bench.deaf = true;
    const auto begin = Clock::now();
    const Outcome waited = ctl("start");
    EXPECT_EQ(waited.status, exit_not_reached) << waited.err;
    EXPECT_NEAR(std::chrono::duration<double>(Clock::now() - begin).count(), 5, 1.5);
}

TEST_F(CtlTest, WaitEndsWithTheStateAndWithItsTimeout) {
    Program waits{"shakerctl", words("wait running --timeout 20s"), folder};
    ASSERT_TRUE(watched());
    EXPECT_FALSE(waits.ended());
    EXPECT_EQ(ctl("start").status, exit_done);
    EXPECT_EQ(waits.wait(limit_s).status, exit_done);
    EXPECT_EQ(ctl("wait running").status, exit_done) << "the state is reached already";
    const Outcome late = ctl("wait idle --timeout 200ms");
    EXPECT_EQ(late.status, exit_timed_out);
    EXPECT_EQ(late.err, "shakerctl: the bench was not idle within 200ms\n");
}

TEST_F(CtlTest, AbortEndsWaitForOtherStates) {
    Program stays{"shakerctl", words("wait stopping"), folder};
    ASSERT_TRUE(watched());
    EXPECT_EQ(ctl("abort").status, exit_done);
    const Outcome vain = stays.wait(limit_s);
    EXPECT_EQ(vain.status, exit_refused);
    EXPECT_EQ(vain.err.substr(0, 33), "shakerctl: the drive was stopped:") << vain.err;
    EXPECT_EQ(ctl("wait tripped").status, exit_done);
    EXPECT_NE(ctl("status").out.find("may be cleared"), std::string::npos);
}

TEST_F(CtlTest, WatchPrintsLinePerSecondAndEveryEvent) {
    bench.bench_port.log(0.5, "note", "before");
    Program watches{"shakerctl", words("watch --seconds 2.5"), folder};
    ASSERT_TRUE(watched());
    for (int i = 0; i < 20; ++i) bench.bench_port.log(1 + i, "note", "number " + std::to_string(i));
    EXPECT_EQ(ctl("start").status, exit_done);
    const Outcome watched = watches.wait(limit_s);
    EXPECT_EQ(watched.status, exit_done) << watched.err;
    const auto lines = lines_of(watched.out);
    EXPECT_EQ(lines.at(0), "at 0.500 s  note: before");
    const auto states =
        std::ranges::count_if(lines, [](const std::string& l) { return l.substr(0, 2) != "at"; });
    EXPECT_TRUE(states == 3 || states == 2) << watched.out;  // 2 if one was late
    EXPECT_EQ(static_cast<long>(lines.size()), states + 22) << watched.out << "21 notes and the start";
    EXPECT_NE(watched.out.find("at 20.000 s  note: number 19\n"), std::string::npos);
    EXPECT_NE(
        lines.back().find("running      20 Hz  asked gamma 9.8 m/s^2  phi 0 rad  v_D 14.500 +- 0.030 mm/s"),
        std::string::npos)
        << lines.back();
}

TEST_F(CtlTest, WatchJsonPrintsOneLinePerMessage) {
    bench.bench_port.log(0.5, "note", "a \x1b[31mred\n note");
    const auto lines = lines_of(ctl("watch --json --seconds 1").out);
    EXPECT_GT(lines.size(), 5U);
    EXPECT_EQ(json::parse(lines.at(0))["text"], "a \x1b[31mred\n note");
    for (const std::string& line : lines) EXPECT_EQ(line.find('\x1b'), std::string::npos);
    EXPECT_EQ(json::parse(lines.back())["type"], "state");
}

TEST_F(CtlTest, WatchEndsOnCtrlCOrClosedOutput) {
    Program watches{"shakerctl", words("watch"), folder};
    ASSERT_TRUE(watched());
    ::kill(watches.pid(), SIGINT);
    EXPECT_EQ(watches.wait(limit_s).status, 128 + SIGINT);
    const auto begin = Clock::now();
    EXPECT_EQ(ctl("watch 2>said | head -n 1 >first; cat first said").out.substr(8, 8), "  idle  ");
    EXPECT_LT(Clock::now() - begin, std::chrono::seconds{5});
    EXPECT_EQ(std::filesystem::file_size(folder / "said"), 0U);
}

TEST_F(CtlTest, FetchPrintsWhatTheDaemonHas) {
    EXPECT_EQ(json::parse(ctl("fetch state").out)["type"], "state");
    EXPECT_EQ(json::parse(ctl("fetch points").out), json::array());
    const Outcome metrics = ctl("fetch metrics");
    EXPECT_EQ(metrics.status, exit_done);
    EXPECT_NE(metrics.out.find("\nshakerd_state{state=\"idle\"} 1\n"), std::string::npos);
}

}  // namespace
}  // namespace shaker::ctl
