// Answers of queries, and the list of HELP.
#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <string>
#include <vector>

#include "tests/support/no_alloc.hpp"
#include "tests/support/remote/scpi_client.hpp"

namespace shaker::scpi {
namespace {

std::string written(double value, Format::Data data) {
    std::string out;
    Reply{out, {.data = data}, 1000}.number(value);
    return out;
}

TEST(ScpiReplyTest, NumbersHaveNineDigitsOrSeventeen) {
    EXPECT_EQ(written(20, Format::Data::ascii), "2.00000000E+01");
    EXPECT_EQ(written(-0.1, Format::Data::real32), "-1.00000000E-01");
    EXPECT_EQ(written(0.1, Format::Data::real64), "1.0000000000000001E-01");
    EXPECT_EQ(written(1e-300, Format::Data::ascii), "1.00000000E-300");
    for (const double value : {0.1, 1 / 3.0, 36.5359e-3, 6.02214076e23, 5e-324})
        EXPECT_EQ(std::strtod(written(value, Format::Data::real64).c_str(), nullptr), value);
}

TEST(ScpiReplyTest, NonFiniteValuesUseStandardNumbers) {
    for (const auto data : {Format::Data::ascii, Format::Data::real64}) {
        EXPECT_EQ(written(std::nan(""), data), "9.91E37");
        EXPECT_EQ(written(HUGE_VAL, data), "9.9E37");
        EXPECT_EQ(written(-HUGE_VAL, data), "-9.9E37");
    }
    test::ScpiBench bench;
    test::ScpiClient client{bench};
    EXPECT_EQ(client.ask("FETC:DRIF?"), "3.65000000E-02,9.91E37,9.9E37,-9.9E37\n");
}

template <class Real, class Bits>
std::vector<double> unpacked(const std::string& reply, std::size_t head, bool swapped) {
    std::vector<double> values;
    for (std::size_t at = head; at + sizeof(Real) < reply.size(); at += sizeof(Real)) {
        Bits bits = 0;
        for (std::size_t i = 0; i < sizeof(Real); ++i) {
            const std::size_t place = swapped ? sizeof(Real) - 1 - i : i;
            bits = static_cast<Bits>(bits << 8U) | static_cast<unsigned char>(reply[at + place]);
        }
        values.push_back(std::bit_cast<Real>(bits));
    }
    return values;
}

TEST(ScpiReplyTest, BlocksHaveRequestedByteOrder) {
    test::ScpiBench bench;
    test::ScpiClient client{bench};
    EXPECT_EQ(client.ask("FORM?;FORM:BORD?"), "ASC,9;NORM\n");
    for (const bool swapped : {false, true}) {
        client.ask(swapped ? "FORM REAL,64;FORM:BORD SWAP" : "FORM REAL,64;FORM:BORD NORM");
        std::string reply = client.ask("FETC:DRIF?");
        ASSERT_EQ(reply.substr(0, 4), "#232");
        EXPECT_EQ((unpacked<double, std::uint64_t>(reply, 4, swapped)),
                  (std::vector<double>{36.5e-3, 9.91e37, 9.9e37, -9.9e37}));
        client.ask("FORM REAL,32");
        reply = client.ask("FETC:DRIF?");
        ASSERT_EQ(reply.substr(0, 4), "#216");
        EXPECT_EQ((unpacked<float, std::uint32_t>(reply, 4, swapped)),
                  (std::vector<double>{36.5e-3F, 9.91e37F, 9.9e37F, -9.9e37F}));
    }
    EXPECT_EQ(client.ask("FORM?;FORM:BORD?"), "REAL,32;SWAP\n");
    client.ask("FORM REAL");
    EXPECT_EQ(client.ask("FORM?;:FREQ?"), "REAL,64;2.0000000000000000E+01\n");
    client.ask("*RST");
    EXPECT_EQ(client.ask("FORM?;FORM:BORD?"), "ASC,9;NORM\n");
}

TEST(ScpiReplyTest, ANumberTooLargeForFourBytesIsInfinite) {
    std::string out;
    Reply{out, {.data = Format::Data::real32}, 1000}.numbers(std::array{1e300});
    EXPECT_EQ((unpacked<float, std::uint32_t>(out + "\n", 3, false)), std::vector<double>{9.9e37F});
}

TEST(ScpiReplyTest, QueryReturnsBoundsOfNumber) {
    test::ScpiBench bench;
    test::ScpiClient client{bench};
    EXPECT_EQ(client.ask("FREQ? MIN;FREQ? maximum;:SOUR:FREQ:FIX? DEF;FREQ?"),
              "1.00000000E+00;2.00000000E+02;2.00000000E+01\n");
    EXPECT_EQ(client.error(), "-113,\"Undefined header;FREQ?\"");
    EXPECT_EQ(client.ask("*ESE? MAX"), "2.55000000E+02\n");
    EXPECT_EQ(client.ask("ACC? DEF"), "9.91E37\n");
    EXPECT_TRUE(client.error().starts_with("-224,"));
}

TEST(ScpiReplyTest, ShortCommandsDoNotAllocate) {
    test::ScpiBench bench;
    test::ScpiClient client{bench};
    const auto exchange = [&] {
        client.session.feed(
            "SOURce:FREQuency 33 HZ;ACCeleration 2.5 G\n*ESR?;:FREQ?;:STAT:OPER?;QUES:COND?\n");
        client.session.sent(client.session.output().size());
    };
    exchange();
    const test::NoAlloc guard;
    for (int i = 0; i < 100; ++i) exchange();
}

/// Removes optional parts such as "[SOURce:]", or only their brackets.
std::string plain(std::string header, bool with_optional) {
    for (std::size_t at = header.find('['); at != std::string::npos; at = header.find('[')) {
        const std::size_t end = header.find(']', at);
        const std::string inside = with_optional ? header.substr(at + 1, end - at - 1) : "";
        header.replace(at, end - at + 1, inside);
    }
    for (std::size_t at = header.find('<'); at != std::string::npos; at = header.find('<'))
        header.replace(at, header.find('>') - at + 1, with_optional ? "1" : "");
    return header;
}

TEST(ScpiReplyTest, HelpListsExactlyTheKnownHeaders) {
    test::ScpiBench bench;
    std::string list;
    {
        test::ScpiClient client{bench};
        list = client.ask("SYST:HELP:HEAD?");
    }
    ASSERT_EQ(list[0], '#');
    const std::size_t head = 2 + static_cast<std::size_t>(list[1] - '0');
    ASSERT_EQ(std::stoul(list.substr(2, head - 2)), list.size() - head - 1);
    std::size_t lines = 0;
    for (std::size_t at = head; at + 1 < list.size(); ++lines) {
        const std::size_t end = list.find('\n', at);
        std::string line = list.substr(at, end - at);
        at = end + 1;
        const bool query_only = line.ends_with("?/qonly/"), no_query = line.ends_with("/nquery/");
        if (query_only) line.erase(line.size() - 8);
        if (no_query) line.erase(line.size() - 8);
        for (const bool with_optional : {false, true})
            for (const bool query : {false, true}) {
                test::ScpiClient client{bench};
                bench.instrument.busy = false;
                client.ask(plain(line, with_optional) + (query ? "?" : ""));
                const bool listed = query ? !no_query : !query_only;
                const bool known = !client.error().starts_with("-113");
                EXPECT_EQ(known, listed) << line << (query ? "?" : "");
            }
    }
    EXPECT_EQ(lines, bench.tree.commands().size());
}

}  // namespace
}  // namespace shaker::scpi
