// Every error number with an input that causes it and its text.
#include <gtest/gtest.h>

#include <set>
#include <string>
#include <vector>

#include "tests/support/remote/scpi_client.hpp"

namespace shaker::scpi {
namespace {

struct Case {
    std::string message;
    std::string error;        // answer of SYSTem:ERRor?
    std::string answer = {};  // answer of a valid query
};

const std::vector<Case> wrong_messages{
    {"FREQ&? 3", "-101,\"Invalid character;FREQ&\""},
    {"\x80\xff", "-101,\"Invalid character;\\x80\""},
    {"FREQ !", "-101,\"Invalid character;SOURce:FREQuency !\""},
    {":", "-102,\"Syntax error;:\""},
    {"20 HZ", "-102,\"Syntax error;2\""},
    {"SOUR::FREQ 3", "-102,\"Syntax error;SOUR::\""},
    {"APPL:BIH 1,,2,3",
     "-102,\"Syntax error;SOURce:APPLy:BIHarmonic a value is missing between separators\""},
    {"FREQ 3,", "-102,\"Syntax error;SOURce:FREQuency a value is missing between separators\""},
    {"FREQ,3", "-103,\"Invalid separator;FREQ,\""},
    {"APPL:BIH 1 2,3",
     "-103,\"Invalid separator;SOURce:APPLy:BIHarmonic 2 where a comma or semicolon was expected\""},
    {"OUTP MAYBE", "-104,\"Data type error;OUTPut MAYBE, allowed ON, OFF or a number\""},
    {"FREQ 3, 4", "-108,\"Parameter not allowed;SOURce:FREQuency takes at most 1 value\""},
    {"FREQ 3,4",
     "-108,\"Parameter not allowed;SOURce:FREQuency takes at most 1 value: a comma separates values; the "
     "decimal sign is a point\""},
    {"FREQ 0,5",
     "-108,\"Parameter not allowed;SOURce:FREQuency takes at most 1 value: a comma separates values; the "
     "decimal sign is a point\""},
    {"FREQ? MIN,4", "-108,\"Parameter not allowed;SOURce:FREQuency? takes at most 1 value\""},
    {"FREQ? 4", "-108,\"Parameter not allowed;SOURce:FREQuency? 4, allowed MIN, MAX or DEF\""},
    {"*RST 1", "-108,\"Parameter not allowed;*RST takes at most 0 values\""},
    {"FREQ", "-109,\"Missing parameter;SOURce:FREQuency needs 1 value, 0 came\""},
    {"APPL:BIH 1,2", "-109,\"Missing parameter;SOURce:APPLy:BIHarmonic needs 3 values, 2 came\""},
    {"FREQUENCIESANDMORE 3", "-112,\"Program mnemonic too long;FREQUENCIESANDMORE, allowed 12 characters\""},
    {"SOUR:FREK 3", "-113,\"Undefined header;SOUR:FREK\""},
    {"FETC:DRIF", "-113,\"Undefined header;FETC:DRIF, there is only a query\""},
    {"BIH:RHO?", "-113,\"Undefined header;BIH:RHO?, there is no query\""},
    {"FREQ2 3", "-114,\"Header suffix out of range;2 in SOURce:FREQuency, no number is allowed there\""},
    {"FREQ 1.2.3", "-121,\"Invalid character in number;SOURce:FREQuency 1.2.\""},
    {"FREQ 1E40000", "-123,\"Exponent too large;SOURce:FREQuency 1E40000, allowed -32000 to 32000\""},
    {"FREQ " + std::string(256, '1'),
     "-124,\"Too many digits;SOURce:FREQuency " + std::string(37, '1') + "... has more than 255\""},
    {"FUNC 3", "-128,\"Numeric data not allowed;SOURce:FUNCtion 3, allowed SIN or BIH or NONE\""},
    {"FREQ 3 V", "-131,\"Invalid suffix;SOURce:FREQuency V, understood: HZ KHZ MHZ\""},
    {"AVER:PER 3 S", "-138,\"Suffix not allowed;AVERage:PERiods S, no unit is allowed here\""},
    {"FREQ FAST", "-141,\"Invalid character data;SOURce:FREQuency FAST, allowed 1 to 200 HZ\""},
    {"REC:NOTE FAST", "-148,\"Character data not allowed;RECord:NOTE FAST, allowed a string in quotes\""},
    {"REC:NOTE \"FAST", "-151,\"Invalid string data;RECord:NOTE \"\"FAST has no closing quote\""},
    {"FREQ '3'", "-158,\"String data not allowed;SOURce:FREQuency '3', allowed 1 to 200 HZ\""},
    {"ARB:DATA #3x", "-161,\"Invalid block data;SOURce:ARBitrary:DATA #3 has no length\""},
    {"FREQ #13abc", "-168,\"Block data not allowed;SOURce:FREQuency #13, allowed 1 to 200 HZ\""},
    {"FREQ (@1)",
     "-170,\"Expression error;SOURce:FREQuency expressions and channel lists are not supported\""},
    {"FREQ 500 HZ", "-222,\"Data out of range;SOURce:FREQuency 500 HZ, allowed 1 to 200 HZ\""},
    {"SOUR:HARM3:AMPL 2", "-222,\"Data out of range;SOURce:HARMonic3:AMPLitude 2, allowed 0 to 1\""},
    {"*ESE 256", "-222,\"Data out of range;*ESE 256, allowed 0 to 255\""},
    {"REC:NOTE 'more than twenty characters'",
     "-223,\"Too much data;RECord:NOTE 27 bytes, allowed at most 20\""},
    {"FUNC SQUare", "-224,\"Illegal parameter value;SOURce:FUNCtion SQUare, allowed SIN or BIH or NONE\""},
    {"ACC DEF",
     "-224,\"Illegal parameter value;SOURce:ACCeleration DEFault is not defined for this parameter\""},
    {"FORM REAL,16", "-224,\"Illegal parameter value;FORMat: 16, allowed 32 or 64\""},
    {"DIAG:FAUL 'input'", "-220,\"Parameter error;DIAGnostic:FAULt: scene.toml: no such key\""},
    {"DIAG:FAUL 'device'", "-240,\"Hardware error;DIAGnostic:FAULt: hw:1: No such device\""},
    {"DIAG:FAUL 'unknown'", "-310,\"System error;DIAGnostic:FAULt: this should not happen\""},
    {"DIAG:SIL?", "-310,\"System error;DIAGnostic:SILent?: no reply was written\"", "9.91E37\n"},
    {"DIAG:FAUL 'trip'", "101,\"Abort;accel Z 61.2 m/s2 > 50\""},
    {"MMEM:DATA? '01234567890'",
     "-430,\"Query DEADLOCKED;MMEMory:DATA?: more than 1048576 bytes in the replies to one message\""},
};

TEST(ScpiErrorTest, ErrorNamesInputAndAllowedValues) {
    for (const Case& wrong : wrong_messages) {
        test::ScpiBench bench;
        test::ScpiClient client{bench};
        EXPECT_EQ(client.ask(wrong.message), wrong.answer) << wrong.message;
        EXPECT_EQ(client.error(), wrong.error) << wrong.message;
        EXPECT_EQ(client.error(), "0,\"No error\"") << wrong.message;
    }
}

TEST(ScpiErrorTest, HandlerExceptionHasNumberAndStandardText) {
    for (const int code : {-200, -203, -211, -213, -220, -221, -222, -223, -224, -230, -240, -241, -250, -256,
                           -310, 101,  102,  103,  104,  105,  106,  107,  108,  109,  110,  111,  112}) {
        test::ScpiBench bench;
        test::ScpiClient client{bench};
        const std::string number = std::to_string(code);
        EXPECT_EQ(client.ask("DIAG:FAUL? '" + number + "'"), "9.91E37\n");
        EXPECT_EQ(client.error(), number + ",\"" + std::string{standard_message(static_cast<Code>(code))} +
                                      ";DIAGnostic:FAULt?: what was wrong\"");
        EXPECT_NE(standard_message(static_cast<Code>(code)), "Unknown error") << code;
    }
}

TEST(ScpiErrorTest, AnErrorSetsTheEventBitOfItsClass) {
    const std::vector<std::pair<std::string, std::string>> cases{{"FREK", "32\n"},
                                                                 {"FREQ 500", "16\n"},
                                                                 {"DIAG:FAUL '-310'", "8\n"},
                                                                 {"DIAG:FAUL '107'", "8\n"},
                                                                 {"MMEM:DATA? '01234567890'", "4\n"}};
    for (const auto& [message, events] : cases) {
        test::ScpiBench bench;
        test::ScpiClient client{bench};
        EXPECT_EQ(client.ask("*ESR?"), "128\n");
        client.ask(message);
        EXPECT_EQ(client.ask("*ESR?"), events) << message;
        EXPECT_EQ(client.ask("*ESR?"), "0\n");
    }
}

TEST(ScpiErrorTest, OnlyCommandErrorDropsRestOfMessage) {
    test::ScpiBench bench;
    test::ScpiClient client{bench};
    client.ask("SOUR:FREK 3;ACC 5;:OUTP ON");
    EXPECT_EQ(bench.acceleration, 9.8);
    EXPECT_TRUE(bench.instrument.told.empty());
    client.ask("SOUR:FREQ 500;ACC 5");
    EXPECT_EQ(bench.acceleration, 5);
    client.ask("FREK 3;:ABOR");
    EXPECT_EQ(bench.last_told(), "abort");
}

TEST(ScpiErrorTest, DataAfterErrorAreNotCommands) {
    for (const char* message :
         {"FREK #15;ABOR", "FREQ 500,#15;ABOR", "FREQ 5, #15;ABOR", "FREK ';ABOR'", "FREQ 5,';ABOR'",
          "FREK \";ABOR", "REC:NOTE \"a\"\"b\" \";ABOR\"", "FREQ 500;FREK #0;ABOR"}) {
        test::ScpiBench bench;
        test::ScpiClient client{bench};
        client.ask(message);
        EXPECT_TRUE(bench.instrument.told.empty()) << message;
        EXPECT_TRUE(client.error().starts_with("-")) << message;
    }
}

TEST(ScpiErrorTest, QuotedInputIsBoundedAndPrintable) {
    test::ScpiBench bench;
    test::ScpiClient client{bench};
    client.ask("FREQ '" + std::string(5000, '"') + "\x01\xfe'");
    std::string error = client.error();
    EXPECT_LE(error.size(), 2 * 255U + 10);
    client.ask("REC:NOTE \"\x01\xfe\x1b[2J\\\"");
    EXPECT_EQ(client.ask("REC:NOTE?"), "\"\\x01\\xfe\\x1b[2J\\\"\n");
    client.ask(std::string(60000, 'A') + ":" + std::string(5000, 'B'));
    error = client.error();
    EXPECT_TRUE(error.starts_with("-112,\"Program mnemonic too long;AAAA")) << error;
    EXPECT_LE(error.size(), 120U);
}

TEST(ScpiErrorTest, AFullQueueEndsInOverflowAndKeepsTheOldest) {
    test::ScpiBench bench;
    test::ScpiClient client{bench};
    for (std::size_t i = 0; i < ErrorQueue::capacity + 5; ++i) client.ask("FREQ " + std::to_string(1000 + i));
    EXPECT_EQ(client.ask("*ESR?"), "152\n");  // power on, execution, device
    for (std::size_t i = 0; i + 1 < ErrorQueue::capacity; ++i)
        EXPECT_TRUE(client.error().starts_with("-222,\"Data out of range;SOURce:FREQuency " +
                                               std::to_string(1000 + i)));
    EXPECT_EQ(client.error(), "-350,\"Queue overflow\"");
    EXPECT_EQ(client.error(), "0,\"No error\"");
}

TEST(ScpiErrorTest, EachClientHasItsOwnErrors) {
    test::ScpiBench bench;
    test::ScpiClient one{bench}, other{bench};
    one.ask("FREK");
    EXPECT_EQ(other.error(), "0,\"No error\"");
    other.session.report(Code::abort, "accel Z 61.2 m/s2 > 50");
    EXPECT_EQ(other.error(), "101,\"Abort;accel Z 61.2 m/s2 > 50\"");
    EXPECT_EQ(one.error(), "-113,\"Undefined header;FREK\"");
}

TEST(ScpiErrorTest, OnlyHolderMaySetOthersMayQueryAndAbort) {
    test::ScpiBench bench;
    test::ScpiClient one{bench, "192.0.2.1:5"}, other{bench, "192.0.2.2:6"};
    EXPECT_EQ(one.ask("SYST:LOCK:OWN?"), "\"\"\n");
    EXPECT_EQ(one.ask("SYST:LOCK:REQ?"), "1\n");
    EXPECT_EQ(other.ask("SYST:LOCK:REQ?;OWN?"), "0;\"192.0.2.1:5\"\n");
    other.ask("SYST:LOCK:REL;:FREQ 33");
    EXPECT_EQ(other.error(),
              "-203,\"Command protected;SOURce:FREQuency: control is held by 192.0.2.1:5; release it there, "
              "or close that page or connection (a page keeps it for 10 s); abort works for everyone\"");
    EXPECT_EQ(other.ask("FREQ?"), "2.00000000E+01\n");
    other.ask("ABOR");
    EXPECT_EQ(bench.last_told(), "abort");
    one.ask("FREQ 33;:SYST:LOCK:REL");
    EXPECT_EQ(other.ask("SYST:LOCK:REQ?;:FREQ 44;FREQ?"), "1;4.40000000E+01\n");
    {
        test::ScpiClient third{bench};
        other.ask("SYST:LOCK:REL");
        EXPECT_EQ(third.ask("SYST:LOCK:REQ?"), "1\n");
    }
    EXPECT_EQ(one.ask("SYST:LOCK:REQ?"), "1\n");
}

}  // namespace
}  // namespace shaker::scpi
