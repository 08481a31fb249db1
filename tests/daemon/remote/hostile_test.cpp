// Slow, greedy, silent and broken clients are closed or slowed down, without effect on other clients.
#include <gtest/gtest.h>
#include <spdlog/fmt/fmt.h>
#include <unistd.h>

#include <chrono>
#include <deque>
#include <fstream>
#include <sstream>
#include <thread>

#include "daemon/remote/access/server_clock.hpp"
#include "daemon/remote/server.hpp"
#include "tests/support/in_real_time.hpp"
#include "tests/support/remote/played_bench.hpp"
#include "tests/support/remote/socket_client.hpp"
#include "tests/support/remote/tcp_client.hpp"

namespace shaker::remote {
namespace {

using namespace std::chrono_literals;
using std::chrono::steady_clock;
using test::PlayedBench;
using test::SocketClient;
using test::TcpClient;

constexpr auto soon = SHAKER_SANITIZED ? 2000ms : 500ms;
constexpr double most_mb = SHAKER_SANITIZED ? 300 : 32;

double resident_mb() {
    std::ifstream in{"/proc/self/statm"};
    double pages = 0, resident = 0;
    in >> pages >> resident;
    return resident * static_cast<double>(::sysconf(_SC_PAGESIZE)) / 1e6;
}

struct HostileTest : testing::Test {
    PlayedBench bench;
    Server server{bench.bench_port, {.http_port = 0, .scpi_port = 0, .silence = 200ms}};
    int http = server.http_port(), scpi = server.scpi_port();

    std::string get(const std::string& path) { return request("GET " + path, {}); }
    std::string post(const std::string& action, const std::string& body = {},
                     const std::string& client = "tab1") {
        return request("POST /api/" + action, body, "X-Shaker-Client: " + client + "\r\n");
    }
    std::string request(const std::string& first, const std::string& body, const std::string& more = {}) {
        TcpClient client{http};
        client.send_bytes(first + " HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n" + more +
                          "Content-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body);
        return client.rest();
    }
    static int status(const std::string& reply) {
        return reply.size() > 12 ? std::stoi(reply.substr(9, 3)) : 0;
    }
    double metric(const std::string& name) {
        const std::string all = get("/metrics");
        const std::size_t at = all.find("\n" + name + " ");
        return at == std::string::npos ? -1 : std::stod(all.substr(at + name.size() + 2));
    }
    void expect_that_others_are_served() {
        const auto begin = steady_clock::now();
        EXPECT_EQ(status(get("/healthz")), 200);
        TcpClient other{scpi};
        EXPECT_EQ(other.ask("SYST:STAT?"), "\"idle\"");
        EXPECT_LT(steady_clock::now() - begin, soon);
    }
    void expect_that_an_abort_gets_through() {
        const int before = bench.aborts;
        const auto begin = steady_clock::now();
        EXPECT_EQ(status(post("abort")), 200);
        EXPECT_LT(steady_clock::now() - begin, soon);
        EXPECT_EQ(bench.aborts, before + 1);
    }
};

TEST_F(HostileTest, SlowHeaderIsCutWhileOthersAreServed) {
    TcpClient slow{http};
    const std::string header = "GET / HTTP/1.1\r\nX-Slow: " + std::string(1000, 'x');
    const auto begin = steady_clock::now();
    std::size_t sent = 0;
    while (sent < header.size() && !slow.closed(50)) {
        slow.send_bytes(header.substr(sent++, 1));
        if (sent % 20 == 0) expect_that_others_are_served();
    }
    EXPECT_GT(steady_clock::now() - begin, 4500ms);
    EXPECT_LT(steady_clock::now() - begin, 5s + 4 * soon);
}

TEST_F(HostileTest, SlowConnectionsDoNotBlockRequests) {
    std::deque<TcpClient> slow;
    for (int i = 0; i < 100; ++i) slow.emplace_back(http).send_bytes("POST /api/st");
    expect_that_an_abort_gets_through();
    EXPECT_EQ(status(get("/readyz")), 200);
    std::this_thread::sleep_for(200ms);
    int closed = 0;
    for (TcpClient& c : slow) closed += c.closed(1) ? 1 : 0;
    EXPECT_GE(closed, 100 - 32);
    EXPECT_LE(closed, 100 - 32 + 4) << "no more connections than needed may be closed";
}

TEST_F(HostileTest, AbortPassesUnansweredOrders) {
    bench.deaf = true;
    std::deque<TcpClient> waits;
    for (int i = 0; i < 40; ++i)
        waits.emplace_back(http).send_bytes(
            "POST /api/start HTTP/1.1\r\nHost: localhost\r\nContent-Length: 0\r\n\r\n");
    expect_that_an_abort_gets_through();
    bench.deaf = false;
}

TEST_F(HostileTest, LiveSocketsLeaveRoomForRequests) {
    std::deque<SocketClient> sockets;
    for (int i = 0; i < 40; ++i) sockets.emplace_back(http, "/ws?client=" + std::to_string(i));
    for (int i = 0; i < 40; ++i) EXPECT_EQ(sockets[static_cast<std::size_t>(i)].status, i < 24 ? 101 : 503);
    expect_that_an_abort_gets_through();
    sockets.clear();
    int again = 0;
    for (int i = 0; i < 200 && again != 101; ++i) {
        again = SocketClient{http}.status;
        std::this_thread::sleep_for(10ms);
    }
    EXPECT_EQ(again, 101) << "a later connection is accepted after their end";
}

TEST_F(HostileTest, ExcessSessionIsRefusedUntilOneIsFreeOrSilent) {
    std::deque<TcpClient> sessions;
    for (int i = 0; i < 16; ++i) EXPECT_EQ(sessions.emplace_back(scpi).ask("*IDN?").substr(0, 7), "shakerd");
    for (int i = 0; i < 30; ++i) {
        TcpClient excess{scpi};
        excess.send("OUTP ON;*IDN?");
        EXPECT_TRUE(excess.rest().find("16 sessions are open") != std::string::npos);
    }
    EXPECT_TRUE(bench.ordered().empty());
    sessions.pop_back();
    std::string got;
    for (int i = 0; i < 200 && got != "1"; ++i) got = sessions.emplace_back(scpi).ask("SYST:LOCK:REQ?");
    EXPECT_EQ(got, "1");
    access::ServerClock::advance(300ms);
    TcpClient late{scpi};
    EXPECT_EQ(late.ask("SYST:LOCK:REQ?"), "0") << "a silent holder of control stays connected";
    EXPECT_TRUE(sessions.front().closed()) << "the session with the longest silence is closed";
}

TEST_F(HostileTest, AbortFloodLeavesEarlierEvents) {
    TcpClient first{scpi}, flood{scpi};
    first.ask("REC:NOTE 'before the flood';:OUTP ON;*OPC?");
    first.ask("ABOR?");
    std::string aborts;
    for (int i = 0; i < 1000; ++i) aborts += "ABOR\n";
    for (int i = 0; i < 100; ++i) flood.send_bytes(aborts);
    flood.ask("*IDN?");
    EXPECT_EQ(bench.aborts, 100001);
    std::string all;
    for (const service::BenchEvent& e : bench.bench_port.events(0)) all += e.kind + ": " + e.text + "\n";
    EXPECT_NE(all.find("remark: before the flood\n"), std::string::npos) << all;
    EXPECT_NE(all.find("order: start (40 periods, until stopped) by 127.0.0.1:"), std::string::npos) << all;
    EXPECT_NE(all.find("order: abort by 127.0.0.1:"), std::string::npos) << all;
    EXPECT_LT(all.size(), 5000U) << all;
}

TEST_F(HostileTest, AbortPassesAThousandWebConnections) {
    std::deque<SocketClient> sockets;
    for (int i = 0; i < 24; ++i) sockets.emplace_back(http, "/ws?client=" + std::to_string(i));
    std::deque<TcpClient> silent;
    for (int n = 25; n < 1000; ++n) {
        silent.emplace_back(http);
        if (silent.size() > 300) silent.pop_front();
        if (n % 100 == 0) expect_that_an_abort_gets_through();
    }
    for (SocketClient& s : sockets) EXPECT_EQ(s.status, 101);
}

TEST_F(HostileTest, UnreadRepliesTakeBoundedMemory) {
    TcpClient greedy{scpi}, other{scpi};
    greedy.ask("*IDN?");
    const double before = resident_mb();
    std::string flood;
    for (int i = 0; i < 4096; ++i) flood += "SYST:HELP:HEAD?\n";
    double most = 0;
    const std::jthread sender{[&] {
        for (int i = 0; i < 32; ++i) greedy.send_bytes(flood);  // 2 MiB with 100 times larger answers
        greedy.send("ABOR");
    }};
    while (bench.aborts == 0 && !testing::Test::HasFailure()) {
        const auto begin = steady_clock::now();
        EXPECT_EQ(other.ask("*IDN?").substr(0, 7), "shakerd");
        EXPECT_LT(steady_clock::now() - begin, soon);
        most = std::max(most, resident_mb() - before);
    }
    EXPECT_EQ(bench.aborts, 1) << "the abort after the unread messages is executed";
    EXPECT_LT(most, most_mb);
    RecordProperty("resident_mb", std::to_string(most));
}

TEST_F(HostileTest, HalfClosedSessionThatDoesNotReadIsClosed) {
    TcpClient greedy{scpi};
    for (int i = 0; i < 20000; ++i) greedy.send("SYST:HELP:HEAD?");
    const auto sessions = [this] { return metric("shakerd_clients{kind=\"scpi\"}"); };
    const auto begin = steady_clock::now();
    while (sessions() != 1 && steady_clock::now() - begin < 2s) std::this_thread::sleep_for(5ms);
    EXPECT_EQ(sessions(), 1);
    greedy.send_no_more();
    access::ServerClock::advance(4500ms);
    std::this_thread::sleep_for(2 * access::ServerWait::longest);
    EXPECT_EQ(sessions(), 1) << "replies are left to read";
    access::ServerClock::advance(1s);
    while (sessions() != 0 && steady_clock::now() - begin < 20s) std::this_thread::sleep_for(10ms);
    EXPECT_EQ(sessions(), 0);
}

// The kernel's timer on the daemon's side of a connection; "02" is the keep-alive timer.
std::string timer_of(int port) {
    std::ifstream in{"/proc/net/tcp"};
    const std::string local = fmt::format(":{:04X}", port);
    std::string line;
    while (std::getline(in, line)) {
        std::istringstream words{line};
        std::string number, from, to, state, queues, timer;
        words >> number >> from >> to >> state >> queues >> timer;
        if (from.ends_with(local) && state == "01") return timer;
    }
    return {};
}

TEST_F(HostileTest, DeadConnectionIsDetected) {
    TcpClient session{scpi};
    session.ask("*IDN?");
    const std::string timer = timer_of(scpi);
    ASSERT_EQ(timer.substr(0, 3), "02:") << timer;
    EXPECT_LE(std::stoul(timer.substr(3), nullptr, 16), 60U * 100) << "hundredths of a second";
}

TEST_F(HostileTest, SocketThatNeverReadsIsClosed) {
    bench.wave = 65536;  // half a megabyte a message
    SocketClient good{http, "/ws?client=good"}, stuck{http, "/ws?client=stuck"};
    const std::string wish = R"({"type":"subscribe","stream":"waveform","rate_hz":30})";
    stuck.send(SocketClient::text, wish);
    EXPECT_EQ(metric("shakerd_stream_messages_dropped_total"), 0);
    const double before = resident_mb();
    double most = 0;
    const auto begin = steady_clock::now();
    int states = 0;
    while (steady_clock::now() - begin < 5s) {
        states += good.next().op == SocketClient::text ? 1 : 0;
        most = std::max(most, resident_mb() - before);
    }
    EXPECT_GT(states, test::in_real_time ? 40 : 20) << "ten a second";
    EXPECT_LT(most, most_mb);
    EXPECT_GT(metric("shakerd_stream_messages_dropped_total"), 50);
    while (metric("shakerd_clients{kind=\"web\"}") > 2 && steady_clock::now() - begin < 20s) good.next();
    EXPECT_EQ(metric("shakerd_clients{kind=\"web\"}"), 2) << "the working client and this request";
    EXPECT_LT(steady_clock::now() - begin, 14s);
    expect_that_others_are_served();
}

TEST_F(HostileTest, WrongFramesEndTheirSocketOnly) {
    const auto ended_by = [this](const auto& what) {
        SocketClient client{http};
        EXPECT_EQ(client.status, 101);
        what(client);
        const bool closed = client.tcp.closed();
        expect_that_others_are_served();
        return closed;
    };
    using C = SocketClient;
    EXPECT_TRUE(ended_by([](C& c) { c.send(C::text, "not masked", true, false); }));
    EXPECT_TRUE(ended_by([](C& c) { c.send(static_cast<C::Op>(3), "an opcode nobody knows"); }));
    EXPECT_TRUE(ended_by([](C& c) { c.send(C::ping, "a ping in pieces", false); }));
    EXPECT_TRUE(ended_by([](C& c) { c.send(C::ping, std::string(126, 'x')); })) << "a too long ping";
    EXPECT_TRUE(ended_by([](C& c) { c.send(C::more, "behind nothing"); }));
    EXPECT_TRUE(ended_by([](C& c) { c.send(C::text, "\xff\xfe"); })) << "not UTF-8";
    EXPECT_TRUE(ended_by([](C& c) { c.send(C::text, std::string(5000, ' ')); })) << "more than 4096 bytes";
    EXPECT_TRUE(ended_by([](C& c) {
        for (int i = 0; i < 5000; ++i) c.send(i == 0 ? C::text : C::more, "x", false);
    })) << "in any number of pieces";
    EXPECT_TRUE(ended_by([](C& c) {
        c.tcp.send_bytes(std::string{"\x82\xff\x7f"} + std::string(12, '\xff'));
    })) << "a length of 2^63";
    EXPECT_TRUE(ended_by([](C& c) { c.tcp.send_bytes("GET / HTTP/1.1\r\n\r\n"); }));
}

TEST_F(HostileTest, MeaninglessRequestsAreIgnored) {
    SocketClient client{http};
    for (const char* no : {"", "{", "[]", "null", R"({"type":1,"stream":2})", R"({"type":"subscribe"})"})
        client.send(SocketClient::text, no);
    client.send(SocketClient::binary, std::string(100, '\0'));
    for (int i = 0; i < 100; ++i)
        client.send(SocketClient::text, R"({"type":"subscribe","stream":")" + std::to_string(i) +
                                            R"(","width":-1e99,"rate_hz":1e99})");
    client.send(SocketClient::text, R"({"type":"unsubscribe","stream":"0"})");
    client.send(SocketClient::text, R"({"type":"subscribe","stream":"acceleration"})");
    int op = SocketClient::text;
    for (int i = 0; i < 100 && op == SocketClient::text; ++i) op = client.next().op;
    EXPECT_EQ(op, SocketClient::binary) << "16 streams were accepted, one ended, so this one is accepted";
}

TEST_F(HostileTest, FloodOfPingsDelaysNobody) {
    SocketClient client{http};
    for (int i = 0; i < 20000; ++i) client.send(SocketClient::ping, "x");
    expect_that_others_are_served();
    int op = SocketClient::text;
    for (int i = 0; i < 100 && op == SocketClient::text; ++i) op = client.next().op;
    EXPECT_EQ(op, SocketClient::pong);
}

TEST_F(HostileTest, PageOfOtherSiteGetsNoSocket) {
    EXPECT_EQ(SocketClient(http, "/ws", "Origin: http://evil.example\r\n").status, 403);
    EXPECT_EQ(SocketClient(http, "/ws", "Origin: null\r\n").status, 403);
    EXPECT_EQ(SocketClient(http, "/ws", "Origin: http://localhost\r\n").status, 101);
    EXPECT_EQ(SocketClient(http, "/api/state", "Origin: http://localhost\r\n").status, 200);
}

TEST_F(HostileTest, OnlyHolderIsObeyedOverBothPorts) {
    TcpClient script{scpi};
    std::size_t obeyed = 0;
    for (int round = 0; round < 20; ++round) {
        const bool page = round % 2 == 0;
        const auto page_asks = [&] { return status(post("control/request")) == 200; };
        const auto script_asks = [&] { return script.ask("SYST:LOCK:REQ?") == "1"; };
        EXPECT_TRUE(page ? page_asks() : script_asks());
        EXPECT_FALSE(page ? script_asks() : page_asks());
        EXPECT_EQ(status(post("drive", R"({"gamma_mps2": 5})")), page ? 200 : 409);
        EXPECT_EQ(script.ask("*CLS;:FREQ 30;*OPC?"), "1");
        std::string error = script.ask("SYST:ERR?");
        while (error.starts_with("101,")) error = script.ask("SYST:ERR?");  // the page's abort
        EXPECT_EQ(error.substr(0, 5), page ? "-203," : "0,\"No");
        EXPECT_EQ(bench.ordered().size(), ++obeyed) << "only the holder's order";
        script.ask("ABOR;:SYST:LOCK:REL;*OPC?");
        EXPECT_EQ(status(post("abort")), 200);
        EXPECT_EQ(bench.aborts, 2 * round + 2) << "aborts of both clients count";
        EXPECT_EQ(status(post("control/release")), 200);
    }
}

}  // namespace
}  // namespace shaker::remote
