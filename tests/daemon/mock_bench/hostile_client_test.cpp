// Clients with control characters in every text: neither the log nor shakerctl prints them.
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <string>
#include <thread>

#include "tests/support/printed.hpp"
#include "tests/support/remote/served_bench.hpp"

namespace shaker::test {
namespace {

/// Answer to a request with this text as the client's name.
std::string posted(int port, const std::string& action, const std::string& body, const std::string& name) {
    TcpClient client{port};
    client.send_bytes("POST /api/" + action +
                      " HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\nX-Shaker-Client: " + name +
                      "\r\nContent-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body);
    return client.rest();
}

/// The next error, which an order that is queued reports a little later.
std::string refusal_of(TcpClient& client) {
    std::string error;
    for (int i = 0; i < 100; ++i) {
        error = client.ask("SYST:ERR?");
        if (!error.starts_with("0,")) break;
        std::this_thread::sleep_for(std::chrono::milliseconds{20});
    }
    return error;
}

TEST(HostileClientTest, ControlsOfClientsAreNotPrinted) {
    ServedBench bench;
    const std::string c1 = "\xc2\x9b"
                           "31m\xe2\x80\xae",
                      escape = R"(\u001b[2J\u009b31m)";
    {
        TcpClient client{bench.scpi_port()};
        client.send("REC:NOTE \"paper\"");
        EXPECT_EQ(client.ask("SYST:ERR?"), "0,\"No error\"");
        for (const std::string& text : {c1,
                                        std::string{"\x9b"
                                                    "31m"},
                                        std::string{"\x1b[2J"}}) {
            client.send("REC:NOTE \"" + text + "\"");
            const std::string error = refusal_of(client);
            EXPECT_NE(error, "0,\"No error\"");
            EXPECT_EQ(controls_in(error), "") << error;
            client.send("*CLS");
            client.send(text + " 3");
            EXPECT_EQ(controls_in(client.ask("SYST:ERR?")), "");
            client.send("*CLS");
        }
    }
    for (const std::string& name : {c1, std::string{"tab\x9b"
                                                    "31m"}}) {
        posted(bench.http_port(), "clear", "{}", name);
        posted(bench.http_port(), "record", R"({"name": ")" + escape + R"("})", name);
        const std::string answer =
            posted(bench.http_port(), "remark", R"({"text": ")" + escape + R"("})", name);
        EXPECT_EQ(answer.find("200 OK"), std::string::npos) << answer;
        posted(bench.http_port(), "remark", R"({"text": "kept"})", name);
    }
    const std::string at = "--at 127.0.0.1:" + std::to_string(bench.http_port()) + " ";
    for (const char* command :
         {"status", "status --json", "fetch state", "fetch metrics", "remark $'a\\xc2\\x9bb'"}) {
        const Outcome o = Program{"shakerctl", at + command, bench.folder}.wait();
        EXPECT_EQ(controls_in(o.out), "") << command << o.out;
        EXPECT_EQ(controls_in(o.err), "") << command << o.err;
    }
    kill(bench.program().pid(), SIGTERM);
    const Outcome served = bench.program().wait(20);
    EXPECT_NE(served.err.find("paper"), std::string::npos) << served.err;
    EXPECT_EQ(controls_in(served.err), "") << served.err;
    EXPECT_EQ(controls_in(served.out), "") << served.out;
}

}  // namespace
}  // namespace shaker::test
