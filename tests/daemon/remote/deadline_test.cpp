// Deadlines of the server. The tests advance its clock instead of waiting.
#include <gtest/gtest.h>

#include <chrono>
#include <deque>
#include <functional>
#include <thread>

#include "daemon/remote/access/server_clock.hpp"
#include "daemon/remote/server.hpp"
#include "tests/support/remote/played_bench.hpp"
#include "tests/support/remote/socket_client.hpp"
#include "tests/support/remote/tcp_client.hpp"

namespace shaker::remote {
namespace {

using namespace std::chrono_literals;
using access::ServerClock;
using test::TcpClient;

// The server reads its clock every 20 ms; requests and answers take less than the rest.
constexpr auto noticed = SHAKER_SANITIZED ? 5000ms : 1000ms;

bool becomes(const std::function<bool()>& state) {
    const auto end = std::chrono::steady_clock::now() + noticed;
    while (!state())
        if (std::chrono::steady_clock::now() > end) return false;
    return true;
}

struct DeadlineTest : testing::Test {
    test::PlayedBench bench;
    Server server{bench.bench_port, {.http_port = 0, .scpi_port = 0, .silence = 60s}};

    int post(const std::string& action, const std::string& client) {
        TcpClient http{server.http_port()};
        http.send_bytes("POST /api/" + action + " HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n" +
                        "X-Shaker-Client: " + client + "\r\nContent-Length: 0\r\n\r\n");
        const std::string reply = http.rest();
        return reply.size() > 12 ? std::stoi(reply.substr(9, 3)) : 0;
    }
};

TEST_F(DeadlineTest, ClosedPageLosesControlAfterTenSeconds) {
    ASSERT_EQ(post("control/request", "one"), 200);
    ServerClock::advance(9s);
    std::this_thread::sleep_for(2 * access::ServerWait::longest);
    EXPECT_EQ(post("control/request", "two"), 409);
    ServerClock::advance(2s);
    EXPECT_TRUE(becomes([&] { return post("control/request", "two") == 200; }));
}

TEST_F(DeadlineTest, PageWithSocketKeepsControl) {
    test::SocketClient page{server.http_port(), "/ws?client=one"};
    ASSERT_EQ(page.status, 101);
    ASSERT_EQ(post("control/request", "one"), 200);
    ServerClock::advance(1h);
    std::this_thread::sleep_for(3 * access::ServerWait::longest);
    EXPECT_EQ(post("control/request", "two"), 409);
}

TEST_F(DeadlineTest, UnansweredOrderIsReportedAfterTenSeconds) {
    bench.deaf = true;
    TcpClient waits{server.http_port()};
    waits.send_bytes(
        "POST /api/start HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n"
        "Content-Length: 0\r\n\r\n");
    std::this_thread::sleep_for(100ms);
    ServerClock::advance(11s);
    const std::string reply = waits.rest();
    EXPECT_TRUE(reply.starts_with("HTTP/1.1 503")) << reply;
    EXPECT_NE(reply.find("the bench did not answer in time"), std::string::npos) << reply;
    bench.deaf = false;
}

TEST_F(DeadlineTest, SilentSessionGivesWayAfterAMinute) {
    std::deque<TcpClient> sessions;
    for (int i = 0; i < 16; ++i)
        ASSERT_EQ(sessions.emplace_back(server.scpi_port()).ask("*IDN?").substr(0, 7), "shakerd");
    ServerClock::advance(59s);
    EXPECT_EQ(TcpClient{server.scpi_port()}.ask("*TST?").substr(0, 5), "-310,");
    ServerClock::advance(2s);
    EXPECT_EQ(sessions.back().ask("*IDN?").substr(0, 7), "shakerd");
    TcpClient late{server.scpi_port()};
    EXPECT_EQ(late.ask("*IDN?").substr(0, 7), "shakerd");
    EXPECT_TRUE(sessions.front().closed());
}

}  // namespace
}  // namespace shaker::remote
