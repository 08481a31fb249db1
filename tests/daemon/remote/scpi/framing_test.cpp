// Messages do not depend on how their bytes arrive, and no client can make the daemon's memory grow.
#include <gtest/gtest.h>

#include <string>

#include "tests/support/remote/scpi_client.hpp"

namespace shaker::scpi {
namespace {

// The block has 17 bytes with characters that elsewhere end a message, start a string or block, or abort.
constexpr char text[] =
    "*IDN?\r\nARB:DATA #217\n;\r\"ABOR\n'#15\0xyz\n;FREQ?\n"
    "REC:NOTE \"a;b\"\"c\";:REC:NOTE?\nFREK\nARB:DATA #0any;thing\nARB:DATA?;*ESR?\nFREQ "
    "#H21;FREQ?\n:SYST:ERR?\n";
const std::string conversation{text, sizeof(text) - 1};

TEST(ScpiFramingTest, SplitMessagesGiveSameReplies) {
    test::ScpiBench whole_bench;
    test::ScpiClient whole{whole_bench};
    whole.session.feed(conversation);
    const std::string expected = whole.read();
    EXPECT_EQ(
        expected,
        "maker,model,1,0.1\n2.00000000E+01\n\"a;b\"\"c\"\n#19any;thing;160\n3.30000000E+01\n-113,\"Undefined "
        "header;FREK\"\n");
    for (std::size_t cut = 0; cut <= conversation.size(); ++cut) {
        test::ScpiBench bench;
        test::ScpiClient client{bench};
        client.session.feed(std::string_view{conversation}.substr(0, cut));
        client.session.feed(std::string_view{conversation}.substr(cut));
        EXPECT_EQ(client.read(), expected) << cut;
    }
    test::ScpiBench bench;
    test::ScpiClient client{bench};
    for (const char c : conversation) client.session.feed({&c, 1});
    EXPECT_EQ(client.read(), expected);
}

// PuTTY's greeting: requests for options, and a list of window sizes, in any pieces.
TEST(ScpiFramingTest, FirstCommandAfterATelnetGreetingIsAnswered) {
    const std::string greeting = "\xFF\xFB\x1F\xFF\xFB\x20\xFF\xFB\x18\xFF\xFD\x03\xFF\xFA\x1F" +
                                 std::string{"\0\x50\0\x18", 4} + "\xFF\xF0";
    const std::string bytes = greeting + "*IDN?\r\nFREK\n:SYST:ERR?\n";
    for (std::size_t cut = 0; cut <= bytes.size(); ++cut) {
        test::ScpiBench bench;
        test::ScpiClient client{bench};
        client.session.feed(std::string_view{bytes}.substr(0, cut));
        client.session.feed(std::string_view{bytes}.substr(cut));
        EXPECT_EQ(client.read(), "maker,model,1,0.1\n-113,\"Undefined header;FREK\"\n") << cut;
    }
}

TEST(ScpiFramingTest, BlockKeepsItsBytes) {
    test::ScpiBench bench;
    test::ScpiClient client{bench};
    std::string bytes;
    for (int i = 0; i < 40000; ++i) bytes += static_cast<char>(i * 7);
    EXPECT_EQ(client.ask("ARB:DATA #540000" + bytes + ";DATA?"), "#540000" + bytes + "\n");
    EXPECT_EQ(bench.wave, bytes);
    client.ask("ARB:DATA #540001" + bytes + "x");
    EXPECT_EQ(client.error(),
              "-223,\"Too much data;SOURce:ARBitrary:DATA 40001 bytes, allowed at most 40000\"");
}

TEST(ScpiFramingTest, TooLongMessageIsSkipped) {
    for (const std::string& flood :
         {std::string(200000, 'A'), "ARB:DATA #6200000" + std::string(200000, '\n'),
          "REC:NOTE '" + std::string(100000, ';') + "'", std::string(65537, ' ')}) {
        test::ScpiBench bench;
        test::ScpiClient client{bench};
        EXPECT_EQ(client.ask(flood), "");
        EXPECT_EQ(client.ask("*TST?"), "0\n");
        EXPECT_EQ(client.error(), "-363,\"Input buffer overrun;message of more than 65536 bytes\"");
        EXPECT_EQ(client.error(), "0,\"No error\"");
    }
}

TEST(ScpiFramingTest, TheLongestMessageIsStillRead) {
    test::ScpiBench bench;
    test::ScpiClient client{bench};
    const std::string query = "*TST?";
    EXPECT_EQ(client.ask(std::string(Session::input_limit - query.size(), ' ') + query), "0\n");
    EXPECT_EQ(client.ask(std::string(Session::input_limit - query.size() + 1, ' ') + query), "");
}

TEST(ScpiFramingTest, UnfinishedQueryIsReportedNotAnswered) {
    test::ScpiBench bench;
    test::ScpiClient client{bench};
    client.session.feed("FREQ 33;FREQ?");
    client.session.finish();
    EXPECT_EQ(client.read(), "");
    EXPECT_EQ(bench.frequency, 20);
    EXPECT_EQ(client.ask("*ESR?"), "132\n");
    EXPECT_EQ(client.error(), "-420,\"Query UNTERMINATED;FREQ 33;FREQ?\"");
    client.session.feed("FREQ 3");
    client.session.finish();
    EXPECT_EQ(client.error(), "0,\"No error\"");
}

TEST(ScpiFramingTest, ClientsThatDoNotReadLoseWholeRepliesOnly) {
    test::ScpiBench bench;
    test::ScpiClient client{bench};
    const std::string query = "MMEM:DATA? '12345'\n";  // 500 kB
    for (int i = 0; i < 3; ++i) client.session.feed(query);
    EXPECT_LE(client.session.output().size(), Session::output_limit);
    client.session.sent(7);
    client.session.feed("*TST?\n");
    EXPECT_EQ(client.read().size(), 2 * 500009U - 7 + 2);
    EXPECT_EQ(client.ask("*ESR?"), "132\n");
    EXPECT_EQ(client.error(),
              "-410,\"Query INTERRUPTED;a message came before the replies to earlier ones were read\"");
}

TEST(ScpiFramingTest, RepliesMayBeSentInAnyPieces) {
    test::ScpiBench bench;
    test::ScpiClient client{bench};
    std::string sent, expected;
    for (int i = 0; i < 1000; ++i) {
        client.session.feed("FREQ " + std::to_string(1 + i % 200) + ";FREQ?\n*IDN?\n");
        const auto size =
            std::min<std::size_t>(client.session.output().size(), static_cast<std::size_t>(i % 60));
        sent += client.session.output().substr(0, size);
        client.session.sent(size);
    }
    sent += client.read();
    test::ScpiClient other{bench};
    for (int i = 0; i < 1000; ++i)
        expected += other.ask("FREQ " + std::to_string(1 + i % 200) + ";FREQ?\n*IDN?");
    EXPECT_EQ(sent, expected);
}

}  // namespace
}  // namespace shaker::scpi
