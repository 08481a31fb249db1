// Headers by SCPI-99 volume 1, chapter 6.
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "daemon/remote/scpi/standard_commands.hpp"
#include "drivers/errors.hpp"
#include "tests/support/remote/scpi_client.hpp"

namespace shaker::scpi {
namespace {

TEST(ScpiHeaderTest, ShortAndLongFormsInAnyCaseAreTheSameCommand) {
    for (const char* header : {"SOURce:FREQuency:FIXed", "SOUR:FREQ", "source:frequency", "sOuRcE:FrEq:FIX",
                               "FREQ", ":FREQ", ":SOUR:FREQ:FIXED", "FREQuency:FIXed"}) {
        test::ScpiBench bench;
        test::ScpiClient client{bench};
        client.ask(std::string{header} + " 33");
        EXPECT_EQ(bench.frequency, 33) << header;
        EXPECT_EQ(client.ask(std::string{header} + "?"), "3.30000000E+01\n") << header;
        EXPECT_EQ(client.error(), "0,\"No error\"") << header;
    }
}

TEST(ScpiHeaderTest, FormsBetweenShortAndLongAreRefused) {
    for (const char* header :
         {"FREQU", "FREQUENC", "FRE", "SOU:FREQ", "SOURC:FREQ", "FREQUENCYS", "SOUR", "FREQ:FIX:FIX", "FIX",
          "SOUR:SOUR:FREQ", "*FREQ", "IDN", "FREQ:", "A:B:C:D:E:F:G:H:I:J"}) {
        test::ScpiBench bench;
        test::ScpiClient client{bench};
        EXPECT_EQ(client.ask(std::string{header} + "?"), "") << header;
        EXPECT_TRUE(client.error().starts_with("-11") || std::string{header} == "FREQ:") << header;
    }
}

TEST(ScpiHeaderTest, SemicolonKeepsPathOfLastHeader) {
    test::ScpiBench bench;
    test::ScpiClient client{bench};
    client.ask("SOUR:BIH:RHO 0.25;PHAS 1;:AVER:PER 7;SETT 3;*CLS;PER 8");
    const std::vector<std::string> told{"rho 0.250000", "phase 1.000000", "periods 7.000000", "settle -1",
                                        "periods 8.000000"};
    EXPECT_EQ(bench.instrument.told, told);
    EXPECT_EQ(client.error(), "0,\"No error\"");
    client.ask("SOUR:BIH:RHO 0.25;FREQ 7");
    EXPECT_EQ(client.error(), "-113,\"Undefined header;FREQ\"");
    client.ask("SOUR:FREQ 7;ACC 3;:OUTP ON");
    EXPECT_EQ(bench.frequency, 7);
    EXPECT_EQ(bench.acceleration, 3);
    EXPECT_EQ(bench.last_told(), "on");
}

TEST(ScpiHeaderTest, ANewMessageBeginsAtTheRoot) {
    test::ScpiBench bench;
    test::ScpiClient client{bench};
    client.ask("SOUR:BIH:RHO 0.25");
    client.ask("PHAS 1");
    EXPECT_EQ(client.error(), "-113,\"Undefined header;PHAS\"");
}

TEST(ScpiHeaderTest, PathKeepsNumericSuffixes) {
    test::ScpiBench bench;
    test::ScpiClient client{bench};
    client.ask("HARM3:AMPL 0.5;PHAS 1;AMPL 0.25");
    EXPECT_EQ(bench.amplitudes[2], 0.25);
    EXPECT_EQ(bench.last_told(), "harmonic phase 3");
    client.ask("SENS2:CAM4:EXP 1MS;SCAL 0.1");
    EXPECT_EQ(bench.instrument.told.at(1), "exposure 2 4 0.001000");
    client.ask("SENSE:CAM3:EXP 0");
    EXPECT_EQ(bench.last_told(), "exposure 1 3 0.000000");
    client.ask("SENS2:CAMERA:EXP 0");
    EXPECT_EQ(bench.last_told(), "exposure 2 1 0.000000");
}

TEST(ScpiHeaderTest, SuffixOutOfRangeIsRefusedWithRange) {
    test::ScpiBench bench;
    test::ScpiClient client{bench};
    for (int n = 1; n <= 16; ++n)
        EXPECT_EQ(client.ask("HARM" + std::to_string(n) + ":AMPL?"), "0.00000000E+00\n");
    client.ask("HARM17:AMPL 1");
    EXPECT_EQ(client.error(),
              "-114,\"Header suffix out of range;SOURce:HARMonic17:AMPLitude, allowed HARMonic1 to 16\"");
    for (const char* wrong :
         {"HARM0:AMPL?", "HARM65535:AMPL?", "HARM99999999999999999999:AMPL?", "FREQ1?", "SENS:CAM5:EXP 1"}) {
        EXPECT_EQ(client.ask(wrong), "") << wrong;
        EXPECT_TRUE(client.error().starts_with("-114,")) << wrong;
    }
}

TEST(ScpiHeaderTest, ControlCharactersAreBlanks) {
    test::ScpiBench bench;
    test::ScpiClient client{bench};
    EXPECT_EQ(client.ask(" \t\r;; FREQ\t \r 33 \r;\v; FREQ?\r"), "3.30000000E+01\n");
    EXPECT_EQ(client.ask(""), "");
    EXPECT_EQ(client.ask("\r"), "");
    EXPECT_EQ(client.error(), "0,\"No error\"");
}

TEST(ScpiHeaderTest, RepliesOfOneMessageAreOneLine) {
    test::ScpiBench bench;
    test::ScpiClient client{bench};
    EXPECT_EQ(client.ask("*IDN?;:FREQ?;*TST?"), "maker,model,1,0.1;2.00000000E+01;0\n");
    EXPECT_EQ(client.ask("FREQ?;FREQ 500;FREQ?"), "2.00000000E+01;2.00000000E+01\n");
}

std::string refusal(std::vector<std::string> headers) {
    std::vector<Command> rows;
    rows.reserve(headers.size());
    for (std::string& header : headers) rows.push_back({.header = std::move(header), .set = [](Call&) {}});
    try {
        const CommandTree tree{std::move(rows)};
    } catch (const InputError& error) {
        return error.what();
    }
    return "accepted";
}

TEST(ScpiHeaderTest, InvalidTableIsRefused) {
    EXPECT_EQ(refusal({"A:B", "A:C", "A[:D]:E"}), "accepted");
    EXPECT_EQ(refusal({"FREQuency", "[SOURce:]FREQuency[:FIXed]"}),
              "[SOURce:]FREQuency[:FIXed] is the same header as FREQuency");
    for (const char* wrong : {"", ":A", "A:", "A::B", "[A:]", "[A:", "A[B]", "A[:B", "A<1>", "A<2..1>",
                              "A<1..70000>", "abc", "THIRTEENCHARS", "A B", "A1", "A:B:C:D:E:F:G:H:I"})
        EXPECT_NE(refusal({wrong}), "accepted") << wrong;
    EXPECT_EQ(refusal({"MODe:A", "MODEl:B"}), "MODEl: its short or long form is a form of another mnemonic");
    EXPECT_EQ(refusal({"A:MODe", "B:MODEl"}), "accepted");
}

}  // namespace
}  // namespace shaker::scpi
