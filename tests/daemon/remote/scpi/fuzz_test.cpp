// No input of a client disturbs the daemon.
#include <gtest/gtest.h>

#include <array>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "tests/support/no_alloc.hpp"
#include "tests/support/remote/scpi_client.hpp"

namespace shaker::scpi {
namespace {

/// Random bytes and elements of the language, in random order.
class Babbler {
public:
    explicit Babbler(unsigned seed) : random_{seed} {}

    std::size_t below(std::size_t n) { return std::uniform_int_distribution<std::size_t>{0, n - 1}(random_); }
    std::string message() {
        std::string text;
        if (below(3) == 0) text = "FREQ 33;HARM3:AMPL?;:FETC:DRIF?;*STB?;:REC:NOTE 'it''s';NOTE?;";
        for (std::size_t words = below(12); words > 0; --words) text += word();
        for (std::size_t flips = below(3); flips > 0 && !text.empty(); --flips)
            text[below(text.size())] = static_cast<char>(below(256));
        return text + (below(8) == 0 ? "" : "\n");
    }

private:
    std::string word() {
        static const std::vector<std::string> words{"SOUR",
                                                    ":",
                                                    ";",
                                                    "FREQ",
                                                    " ",
                                                    "?",
                                                    "HARM",
                                                    "3",
                                                    ":AMPL",
                                                    ",",
                                                    "1E3",
                                                    " HZ",
                                                    "MAX",
                                                    "#15a;b\nc",
                                                    "#0",
                                                    "#H1F",
                                                    "\"a\"\"",
                                                    "'",
                                                    "\"",
                                                    "*IDN?",
                                                    "*WAI",
                                                    "*OPC?",
                                                    "*OPC",
                                                    "*CLS",
                                                    "*ESR?",
                                                    "*STB?",
                                                    "INIT",
                                                    "ABOR",
                                                    ":ABOR",
                                                    "SYST:ERR?",
                                                    "FORM REAL,64",
                                                    "FETC:DRIF?",
                                                    "STAT:OPER:ENAB 5",
                                                    "FREQ 33",
                                                    "ACC 2G",
                                                    "REC:NOTE ",
                                                    "OUTP ON",
                                                    "ARB:DATA ",
                                                    "#3",
                                                    "-",
                                                    ".",
                                                    "1.5",
                                                    "APPL:BIH 1,2,0.3,4",
                                                    "DIAG:FAUL 'device'",
                                                    "SYST:HELP:HEAD?",
                                                    "FREQ?;*TST?",
                                                    "*RST",
                                                    "SYST:LOCK:REQ?",
                                                    "SYST:LOCK:REL"};
        if (below(10) > 0) return words[below(words.size())];
        std::string bytes(below(20), '\0');
        for (char& c : bytes) c = static_cast<char>(below(256));
        return bytes;
    }
    std::mt19937 random_;
};

TEST(ScpiFuzzTest, RandomMessagesLeaveClientsAndMemoryIntact) {
    test::ScpiBench bench;
    std::array<std::unique_ptr<test::ScpiClient>, 2> clients;
    for (auto& client : clients) client = std::make_unique<test::ScpiClient>(bench);
    Babbler babbler{20260101};
    std::size_t replies = 0, most_blocks = 0;
    const test::HeapCalls before = test::heap_calls();
    for (int i = 0; i < 200'000; ++i) {
        auto& place = clients[babbler.below(2)];
        if (!place->session.ended().empty()) place = std::make_unique<test::ScpiClient>(bench);
        test::ScpiClient& who = *place;
        const std::string message = babbler.message();
        const std::size_t cut = babbler.below(message.size() + 1);
        who.session.feed(std::string_view{message}.substr(0, cut));
        who.session.feed(std::string_view{message}.substr(cut));
        if (babbler.below(5) == 0) bench.instrument.busy = false;
        if (babbler.below(5) == 0) who.session.poll();
        if (babbler.below(100) == 0) who.session.finish();  // ends a block of a gigabyte
        ASSERT_LE(who.session.output().size(), Session::output_limit);
        ASSERT_LE(who.session.status().errors.size(), ErrorQueue::capacity);
        const std::string read = who.read();
        ASSERT_TRUE(read.empty() || read.back() == '\n');
        replies += read.empty() ? 0 : 1;
        bench.instrument.told.clear();
        const test::HeapCalls now = test::heap_calls();
        most_blocks = std::max(most_blocks, (now.taken - before.taken) - (now.returned - before.returned));
    }
    EXPECT_GT(replies, 5000U);
    EXPECT_LT(most_blocks, 3000U);  // two clients that withhold 64 KiB of the shortest messages take 2000
    bench.instrument.busy = false;
    for (const auto& who : clients) {
        if (!who->session.ended().empty()) continue;
        who->session.finish();
        who->session.poll();
        who->read();
        EXPECT_EQ(who->ask("*CLS;*TST?"), "0\n");
        EXPECT_EQ(who->error(), "0,\"No error\"");
    }
}

}  // namespace
}  // namespace shaker::scpi
