// A client that speaks another protocol is not obeyed, and a password keeps others out.
#include "daemon/remote/scpi/foreign.hpp"

#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

#include "tests/support/remote/scpi_client.hpp"

namespace shaker::scpi {
namespace {

const std::string orders = "FREQ 33\r\nACC 9.8\r\nOUTP ON\r\nABOR\r\nOUTP ON;*IDN?\r\n";

std::string post(const std::string& first, const std::string& body = orders) {
    return first + "\r\nHost: 127.0.0.1:5025\r\nOrigin: http://elsewhere.example\r\nContent-Length: " +
           std::to_string(body.size()) + "\r\n\r\n" + body;
}

bool obeyed(const test::ScpiBench& bench) {
    return !bench.instrument.told.empty() || bench.frequency != 20 || bench.acceleration != 9.8;
}

void expect_deaf(const std::string& bytes, std::size_t cut) {
    test::ScpiBench bench;
    test::ScpiClient client{bench};
    client.session.feed(std::string_view{bytes}.substr(0, cut));
    client.session.feed(std::string_view{bytes}.substr(cut));
    EXPECT_FALSE(client.session.ended().empty()) << bytes;
    EXPECT_FALSE(obeyed(bench)) << bytes;
    EXPECT_EQ(client.ask("OUTP ON;*IDN?"), "") << "later lines are not obeyed either";
    client.session.finish();
    client.session.poll();
    EXPECT_FALSE(obeyed(bench)) << bytes;
    EXPECT_EQ(client.read(), "");
}

TEST(ScpiForeignTest, BrowserIsNotObeyedHoweverSplit) {
    const std::string bytes = post("POST / HTTP/1.1");
    for (std::size_t cut = 0; cut <= bytes.size(); ++cut) expect_deaf(bytes, cut);
}

TEST(ScpiForeignTest, RequestIsKnownInEveryForm) {
    for (const char* first :
         {"GET / HTTP/1.1", "post /x http/1.0", "\r\n\r\nPOST / HTTP/1.1", " \t POST /'\"#15 HTTP/1.1",
          "OPTIONS * HTTP/1.1", "PRI * HTTP/2.0", "CONNECT bench:5025 HTTP/1.1", "GET http://bench/ HTTP/1.1",
          "POST /;OUTP%20ON", "Host: bench", "host:bench", "X-Anything: 1", "Content-Type: text/plain"})
        expect_deaf(post(first), 0);
    expect_deaf(post("POST /" + std::string(200000, 'a') + " HTTP/1.1"), 0);
    expect_deaf("FREK\r\n" + post("POST / HTTP/1.1"), 3);
}

TEST(ScpiForeignTest, BinaryProtocolIsNotObeyed) {
    for (const char first : {'\x16', '\x00', '\x01'})
        expect_deaf(std::string{first} + "\x03\x01\r\n" + orders, 1);
}

TEST(ScpiForeignTest, RandomRequestsGiveNoOrder) {
    std::mt19937 random{20261123};
    const auto below = [&](std::size_t n) { return static_cast<std::size_t>(random() % n); };
    const std::vector<std::string> methods{"GET", "POST", "PUT", "options", "PROPFIND", "M-SEARCH"};
    const std::vector<std::string> pieces{"/", "a", "'", "\"", "#",   "#12",
                                          ";", ":", "?", ",",  "%0a", "OUTP:ON"};
    for (int i = 0; i < 20000; ++i) {
        std::string target = "/";
        for (std::size_t n = below(20); n > 0; --n) target += pieces[below(pieces.size())];
        std::string body = orders;
        for (std::size_t n = below(5); n > 0; --n)
            body.insert(below(body.size()), pieces[below(pieces.size())]);
        const std::string blank = std::string(below(3), '\n') + std::string(below(3), ' ');
        const std::string bytes =
            post(blank + methods[below(methods.size())] + " " + target + " HTTP/1.1", body);
        test::ScpiBench bench;
        test::ScpiClient client{bench};
        for (std::string_view rest = bytes; !rest.empty();) {
            const std::size_t piece = 1 + below(rest.size());
            client.session.feed(rest.substr(0, piece));
            rest.remove_prefix(piece);
        }
        ASSERT_FALSE(obeyed(bench)) << bytes;
        ASSERT_EQ(client.read(), "") << bytes;
    }
}

TEST(ScpiForeignTest, CommandsAreNotTakenForHttp) {
    test::ScpiBench bench;
    for (const Command& command : bench.tree.commands()) {
        EXPECT_FALSE(is_http_line(command.header + " 1")) << command.header;
        EXPECT_FALSE(is_http_line(command.header + "?")) << command.header;
    }
    test::ScpiClient client{bench};
    EXPECT_EQ(client.ask("REC:NOTE 'GET / HTTP/1.1';NOTE?"), "\"GET / HTTP/1.1\"\n");
    EXPECT_EQ(client.ask("ARB:DATA #216\nPOST / HTTP/1.1;*TST?"), "0\n") << "bytes of a block";
    EXPECT_EQ(client.session.ended(), "");
}

struct ScpiPasswordTest : testing::Test {
    test::ScpiBench bench;
    test::ScpiClient client{bench, "192.0.2.1:5", Admission::password};
    ScpiPasswordTest() { bench.access.token = "0123456789abcdefghijkl"; }
};

TEST_F(ScpiPasswordTest, OnlyAbortAndErrorsAreOpenWithoutIt) {
    EXPECT_EQ(client.ask("*IDN?"), "maker,model,1,0.1\n");
    EXPECT_EQ(client.ask("SYST:PASS:STAT?"), "0\n");
    EXPECT_EQ(client.ask("OUTP ON;FREQ?"), "9.91E37\n");
    EXPECT_EQ(client.error().substr(0, 5), "-203,");
    EXPECT_EQ(client.error().substr(0, 5), "-203,");
    EXPECT_FALSE(obeyed(bench));
    for (const Command& command : bench.tree.commands()) {
        if (command.open) continue;
        std::string header;
        for (std::size_t i = 0; i < command.header.size(); ++i)
            if (command.header[i] == '<')
                header += command.header[++i], i = command.header.find('>', i);
            else if (command.header[i] != '[' && command.header[i] != ']')
                header += command.header[i];
        client.ask("*CLS;:" + header + (command.set ? " 1" : "?"));
        EXPECT_EQ(client.error().substr(0, 5), "-203,") << header;
    }
    EXPECT_FALSE(obeyed(bench));
    client.ask("ABOR");
    EXPECT_EQ(bench.last_told(), "abort");
}

TEST_F(ScpiPasswordTest, RightPasswordOpensUntilTakenBack) {
    client.ask("SYST:PASS '0123456789abcdefghijkl';:OUTP ON");
    EXPECT_EQ(bench.last_told(), "on");
    EXPECT_EQ(client.ask("SYST:PASS:STAT?;:SYST:ERR?"), "1;0,\"No error\"\n");
    client.ask("SYST:PASS:CDIS;:OUTP OFF");
    EXPECT_EQ(bench.last_told(), "on");
    EXPECT_EQ(client.error().substr(0, 5), "-203,");
    client.ask("SYST:PASS:CEN \"0123456789abcdefghijkl\"");
    bench.access.token = "another token of the daemon";
    EXPECT_EQ(client.ask("SYST:PASS:STAT?"), "0\n") << "a new token asks again";
}

TEST_F(ScpiPasswordTest, ThreeWrongPasswordsEndTheSession) {
    for (const char* wrong : {"", "0123456789abcdefghijkL"}) {
        client.ask(std::string{"SYST:PASS '"} + wrong + "'");
        EXPECT_EQ(client.error().substr(0, 5), "-221,");
    }
    EXPECT_EQ(client.session.ended(), "");
    client.ask("SYST:PASS 'x';PASS '0123456789abcdefghijkl';:OUTP ON");
    EXPECT_NE(client.session.ended(), "");
    EXPECT_FALSE(obeyed(bench));
    EXPECT_EQ(client.ask("*IDN?"), "");
}

TEST_F(ScpiPasswordTest, NoneIsNeededWithoutTokenOrLocally) {
    test::ScpiClient local{bench, "local client 1", Admission::free};
    EXPECT_EQ(local.ask("SYST:PASS:STAT?;:OUTP ON;*TST?"), "1;0\n");
    EXPECT_EQ(bench.last_told(), "on");
    bench.access.token.clear();
    EXPECT_EQ(client.ask("OUTP OFF;*TST?"), "0\n");
    EXPECT_EQ(bench.last_told(), "off");
}

}  // namespace
}  // namespace shaker::scpi
