// Who may order: pages of other sites, clients without the password, clients of the Unix socket. And the
// server goes on after an error of its own.
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>

#include "daemon/remote/server.hpp"
#include "drivers/errors.hpp"
#include "tests/support/program.hpp"
#include "tests/support/remote/played_bench.hpp"
#include "tests/support/remote/tcp_client.hpp"

namespace shaker::remote {
namespace {

using namespace std::chrono_literals;
using test::PlayedBench;
using test::TcpClient;

const std::string token = "0123456789abcdefghijkl";

struct DoorsTest : testing::Test {
    std::filesystem::path folder = test::fresh_folder(), path = folder / "scpi";
    PlayedBench bench;
    Server server{bench.bench_port,
                  {.http_port = 0, .scpi_port = 0, .scpi_socket = path, .token = token, .page = folder}};

    std::string get(const std::string& target) {
        TcpClient client{server.http_port()};
        client.send_bytes("GET " + target + " HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n" +
                          "X-Shaker-Token: " + token + "\r\n\r\n");
        return client.rest();
    }
    bool logged(const std::string& words) {
        for (int i = 0; i < 200; ++i) {
            for (const service::BenchEvent& e : bench.bench_port.events(0))
                if (e.text.find(words) != std::string::npos) return true;
            std::this_thread::sleep_for(5ms);
        }
        return false;
    }
};

TEST_F(DoorsTest, PageOfAnotherSiteStartsNothing) {
    const std::string body = "SYST:PASS '" + token + "'\nACC 9.8\nOUTP ON\n";
    for (const std::size_t piece : {1U, 7U, 4096U}) {
        TcpClient browser{server.scpi_port()};
        std::string bytes = "POST / HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(server.scpi_port()) +
                            "\r\nContent-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body;
        for (; !bytes.empty(); bytes.erase(0, piece)) browser.send_bytes(bytes.substr(0, piece));
        EXPECT_EQ(browser.rest(), "");
        TcpClient{path}.ask("*OPC?");
        EXPECT_TRUE(bench.ordered().empty());
    }
    EXPECT_EQ(TcpClient{path}.ask("SYST:STAT?"), "\"idle\"");
    EXPECT_TRUE(logged("was closed: it spoke HTTP"));
}

TEST_F(DoorsTest, TokenIsAskedFromNetworkClients) {
    TcpClient client{server.scpi_port()};
    EXPECT_EQ(client.ask("OUTP ON;*IDN?").substr(0, 8), "shakerd,");
    EXPECT_EQ(client.ask("SYST:ERR?").substr(0, 5), "-203,");
    EXPECT_EQ(client.ask("ABOR?"), "1");
    EXPECT_EQ(bench.aborts, 1);
    EXPECT_EQ(client.ask("SYST:PASS '" + token + "';:OUTP:PROT:CLE;*OPC?"), "1");
    EXPECT_EQ(bench.ordered().size(), 1U);
    server.adopt({.token = "another token of this daemon", .page = folder});
    std::string open;
    for (int i = 0; i < 200 && open != "0"; ++i) open = client.ask("SYST:PASS:STAT?");
    EXPECT_EQ(open, "0") << "a new token is asked from open sessions too";
}

TEST_F(DoorsTest, GuessingEndsTheConnection) {
    TcpClient client{server.scpi_port()};
    for (int i = 0; i < 3; ++i) client.send("SYST:PASS '" + std::to_string(i) + "'");
    EXPECT_TRUE(client.closed());
    EXPECT_TRUE(logged("wrong passwords"));
}

TEST_F(DoorsTest, UnixSocketNeedsNoPassword) {
    TcpClient client{path};
    EXPECT_EQ(client.ask("SYST:LOCK:REQ?"), "1");
    EXPECT_EQ(client.ask("ACC 5;*OPC?"), "1");
    EXPECT_EQ(bench.ordered().size(), 1U);
    EXPECT_EQ(client.ask("SYST:LOCK:OWN?").substr(0, 14), "\"local client ");
    struct stat facts {};
    ASSERT_EQ(::stat(path.c_str(), &facts), 0);
    EXPECT_TRUE(S_ISSOCK(facts.st_mode));
    EXPECT_EQ(facts.st_mode & 0777U, 0660U);
    TcpClient browser{path};
    browser.send_bytes("GET / HTTP/1.1\r\n");
    EXPECT_TRUE(browser.closed());
}

TEST_F(DoorsTest, SocketInUseIsNotTakenOver) {
    EXPECT_THROW(Server(bench.bench_port, {.http_port = 0, .scpi_port = 0, .scpi_socket = path}),
                 DeviceError);
    EXPECT_EQ(TcpClient{path}.ask("*TST?"), "0");
    std::ofstream{folder / "file"} << "no socket";
    EXPECT_THROW(Server(bench.bench_port, {.http_port = 0, .scpi_port = 0, .scpi_socket = folder / "file"}),
                 DeviceError);
    EXPECT_TRUE(std::filesystem::is_regular_file(folder / "file"));
}

TEST_F(DoorsTest, SocketLeftBehindIsReplacedAndRemoved) {
    const std::filesystem::path left = folder / "left";
    const int killed = ::socket(AF_UNIX, SOCK_STREAM, 0);
    sockaddr_un at{};
    at.sun_family = AF_UNIX;
    left.string().copy(at.sun_path, sizeof at.sun_path - 1);
    ASSERT_EQ(::bind(killed, reinterpret_cast<const sockaddr*>(&at), sizeof at), 0);
    ::close(killed);
    {
        const Server second{bench.bench_port, {.http_port = 0, .scpi_port = 0, .scpi_socket = left}};
        EXPECT_EQ(TcpClient{left}.ask("*TST?"), "0");
    }
    EXPECT_FALSE(std::filesystem::exists(left));
}

TEST_F(DoorsTest, AnotherAddressNeedsAToken) {
    const ServerSettings open{.address = "0.0.0.0", .http_port = 0, .scpi_port = 0};
    try {
        const Server refused{bench.bench_port, open};
        ADD_FAILURE() << "it listens";
    } catch (const InputError& e) {
        EXPECT_NE(std::string{e.what()}.find("token_file"), std::string::npos) << e.what();
    }
}

TEST_F(DoorsTest, ServerGoesOnAfterAnErrorOfItsOwn) {
    std::filesystem::create_directory(folder / "index.html");  // reading it throws in the server's thread
    for (int i = 0; i < 3; ++i) server.adopt({.token = "a token that is not adopted", .page = folder});
    EXPECT_TRUE(logged("internal error in the remote control"));
    EXPECT_EQ(TcpClient{path}.ask("*TST?"), "0");
    std::string metrics;
    for (int i = 0; i < 200 && metrics.find("failures_total 3") == std::string::npos; ++i) {
        metrics = get("/metrics");
        std::this_thread::sleep_for(5ms);
    }
    EXPECT_NE(metrics.find("shakerd_remote_failures_total 3\n"), std::string::npos) << metrics;
    EXPECT_TRUE(server.alive());
}

TEST_F(DoorsTest, AThreadThatStandsStillIsSeen) {
    EXPECT_TRUE(server.alive());
    std::atomic<bool> held{true};
    bench.bench_port.stop_by(
        [&]() -> std::uint64_t {
            while (held) std::this_thread::sleep_for(1ms);
            return 1;
        },
        [] { return std::uint64_t{1}; });
    TcpClient client{path};
    client.send("ABOR");
    for (int i = 0; i < 400 && server.alive(); ++i) std::this_thread::sleep_for(5ms);
    EXPECT_FALSE(server.alive());
    held = false;
    EXPECT_EQ(client.ask("*TST?"), "0");
    for (int i = 0; i < 400 && !server.alive(); ++i) std::this_thread::sleep_for(5ms);
    EXPECT_TRUE(server.alive());
}

}  // namespace
}  // namespace shaker::remote
