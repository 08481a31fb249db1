// Data elements by IEEE 488.2 chapter 7.7, and their values.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "daemon/remote/scpi/error.hpp"
#include "daemon/remote/scpi/parameter.hpp"

namespace shaker::scpi {
namespace {

constexpr double any = std::numeric_limits<double>::infinity();

Argument taken(std::string text, const Parameter& parameter) {
    Text all{text.data(), text.data() + text.size()};
    const Argument argument = to_argument(read_element(all), parameter);
    EXPECT_TRUE(all.empty()) << text;
    return argument;
}

double value(const std::string& text, const std::string& unit = "") {
    return taken(text, number(unit, -any, any)).number;
}

int refused(std::string text, const Parameter& parameter) {
    Text all{text.data(), text.data() + text.size()};
    try {
        to_argument(read_element(all), parameter);
    } catch (const Error& error) {
        EXPECT_LE(std::string{error.what()}.size(), 300U);
        return static_cast<int>(error.code);
    }
    return 0;
}

TEST(ScpiValueTest, NumbersAreReadInAllTheirForms) {
    const std::vector<std::pair<std::string, double>> cases{
        {"1", 1},
        {"+1", 1},
        {"-1", -1},
        {"1.", 1},
        {".5", 0.5},
        {"-.5", -0.5},
        {"1.5", 1.5},
        {"1e3", 1e3},
        {"1E+3", 1e3},
        {"1E-3", 1e-3},
        {"1.5 E 3", 1500},
        {"1 e-3", 1e-3},
        {"007", 7},
        {"0.1", 0.1},
        {"1E400", any},
        {"-1E400", -any},
        {"1E-400", 0},
        {"0E30000", 0},
        {"#HFF", 255},
        {"#hff", 255},
        {"#Q17", 15},
        {"#B1010", 10},
        {"#b0", 0},
        {"#HFFFFFFFFFFFFFFFF", 18446744073709551615.0},
        {std::string(255, '1'), std::stod(std::string(255, '1'))},
        {"2.2250738585072014E-308", 2.2250738585072014e-308}};
    for (const auto& [text, expected] : cases) EXPECT_EQ(value(text), expected) << text;
}

TEST(ScpiValueTest, MalformedNumbersAreRefused) {
    const Parameter plain = number("", -any, any);
    const std::vector<std::pair<std::string, int>> cases{{"+", -121},
                                                         {"-", -121},
                                                         {".", -121},
                                                         {"1.2.3", -121},
                                                         {"1$", -121},
                                                         {"1\"", -121},
                                                         {"--1", -121},
                                                         {"1E32001", -123},
                                                         {"1E-32001", -123},
                                                         {"1E99999999999999999999", -123},
                                                         {std::string(256, '1'), -124},
                                                         {"#HFFFFFFFFFFFFFFFFF", -124},
                                                         {"#H", -121},
                                                         {"#HXY", -121},
                                                         {"#B12", -121},
                                                         {"#Q8", -121},
                                                         {"1 HZ", -138},
                                                         {"1HZ", -138},
                                                         {"1E", -138},
                                                         {"\xff", -101},
                                                         {"!", -101},
                                                         {"(1+2)", -170},
                                                         {"#", -161},
                                                         {"#Z", -161}};
    for (const auto& [text, code] : cases) EXPECT_EQ(refused(text, plain), code) << text;
}

TEST(ScpiValueTest, UnitsAreScaledAndMIsMilliExceptMegahertz) {
    const double pi = std::numbers::pi;
    const std::vector<std::tuple<std::string, std::string, double>> cases{{"20", "HZ", 20},
                                                                          {"20HZ", "HZ", 20},
                                                                          {"20 hz", "HZ", 20},
                                                                          {"0.02 KHZ", "HZ", 20},
                                                                          {"1MHZ", "HZ", 1e6},
                                                                          {"1E3HZ", "HZ", 1e3},
                                                                          {"50MS", "S", 50e-3},
                                                                          {"7 US", "S", 7e-6},
                                                                          {"3 S", "S", 3},
                                                                          {"2MV", "V", 2e-3},
                                                                          {"1.5G", "M/S2", 1.5 * 9.8},
                                                                          {"3 M/S2", "M/S2", 3},
                                                                          {"180 DEG", "RAD", pi},
                                                                          {"1 MRAD", "RAD", 1e-3},
                                                                          {"5 MM", "M", 5e-3},
                                                                          {"5 UM", "M", 5e-6},
                                                                          {"5", "MM", 5},
                                                                          {"5 MM", "MM", 5},
                                                                          {"0.005 M", "MM", 5},
                                                                          {"5000 UM", "MM", 5},
                                                                          {"5 PCT", "1", 0.05},
                                                                          {"20 DB", "1", 10},
                                                                          {"0.3", "1", 0.3},
                                                                          {"50", "PCT", 50},
                                                                          {"0.1 MM/PX", "MM/PX", 0.1},
                                                                          {"0.1 V/(M/S2)", "V/(M/S2)", 0.1},
                                                                          {"1 M/S", "M/S", 1}};
    for (const auto& [text, unit, expected] : cases) EXPECT_DOUBLE_EQ(value(text, unit), expected) << text;
    EXPECT_EQ(value("50MS", "S"), 0.05);  // rounded once
    for (const char* wrong : {"1 V", "1 M", "1 HZZ", "1 M/S", "1 DB"})
        EXPECT_NE(refused(wrong, number("HZ", -any, any)), 0) << wrong;
    EXPECT_EQ(refused("1 V", number("HZ", -any, any)), -131);
    EXPECT_EQ(refused("1 PX", number("MM/PX", -any, any)), -131);
}

TEST(ScpiValueTest, BoundsHaveNamesAndAreIncluded) {
    const Parameter frequency = number("HZ", 1, 200, 20);
    for (const char* text : {"MIN", "minimum", "1", "1 HZ"})
        EXPECT_EQ(taken(text, frequency).number, 1) << text;
    for (const char* text : {"MAX", "MAXimum", "200", "0.2KHZ"})
        EXPECT_EQ(taken(text, frequency).number, 200) << text;
    for (const char* text : {"DEF", "default"}) EXPECT_EQ(taken(text, frequency).number, 20) << text;
    for (const char* text : {"0.999999", "200.0000001", "1E400", "-5"})
        EXPECT_EQ(refused(text, frequency), -222) << text;
    EXPECT_EQ(refused("MAX", number("", 0, any)), -224);
    EXPECT_EQ(refused("DEF", number("", 0, 1)), -224);
    EXPECT_EQ(refused("MINI", frequency), -141);
    EXPECT_EQ(refused("THIRTEENCHARS", frequency), -141);
}

TEST(ScpiValueTest, IntegersAreRoundedBeforeTheyAreChecked) {
    const Parameter count = integer(1, 16, 4);
    EXPECT_EQ(taken("2.4", count).number, 2);
    EXPECT_EQ(taken("2.5", count).number, 3);
    EXPECT_EQ(taken("16.4", count).number, 16);
    EXPECT_EQ(refused("16.5", count), -222);
    EXPECT_EQ(refused("2 HZ", count), -138);
    EXPECT_EQ(taken("#HF", count).number, 15);
}

TEST(ScpiValueTest, BooleansAreWordsOrNumbers) {
    for (const char* text : {"ON", "on", "1", "-3", "0.5", "#B1"})
        EXPECT_TRUE(taken(text, boolean()).on) << text;
    for (const char* text : {"OFF", "Off", "0", "0.4", "-0.4"})
        EXPECT_FALSE(taken(text, boolean()).on) << text;
    EXPECT_EQ(refused("MAYBE", boolean()), -104);
    EXPECT_EQ(refused("1 V", boolean()), -138);
}

TEST(ScpiValueTest, ChoiceIsIndexOfWord) {
    const Parameter shape = choice("SINusoid|BIHarmonic|NONE");
    EXPECT_EQ(taken("sin", shape).word, 0);
    EXPECT_EQ(taken("BIHARMONIC", shape).word, 1);
    EXPECT_EQ(taken("NONE", shape).word, 2);
    EXPECT_EQ(refused("SINUS", shape), -224);
    const Parameter settle = or_word("AUTO", integer(1, 10));
    EXPECT_EQ(taken("auto", settle).word, 0);
    EXPECT_EQ(taken("7", settle).word, -1);
    EXPECT_EQ(taken("7", settle).number, 7);
}

TEST(ScpiValueTest, StringsUndoDoubledQuotes) {
    std::string text;  // the content is a view into it
    const auto content = [&](const char* raw) {
        text = raw;
        Text all{text.data(), text.data() + text.size()};
        return std::string{to_argument(read_element(all), string(10)).text};
    };
    EXPECT_EQ(content("\"\""), "");
    EXPECT_EQ(content("\"a;b,c\""), "a;b,c");
    EXPECT_EQ(content("\"a\"\"b\""), "a\"b");
    EXPECT_EQ(content("'a\"b'"), "a\"b");
    EXPECT_EQ(content("'it''s'"), "it's");
    EXPECT_EQ(content("\"\"\"\""), "\"");
    EXPECT_EQ(refused("\"open", string()), -151);
    EXPECT_EQ(refused("\"open\"\"", string()), -151);
    EXPECT_EQ(refused("\"eleven char\"", string(10)), -223);
}

TEST(ScpiValueTest, BlocksAreBytes) {
    std::string text{"#15\0\n;\"x", 8};
    Text all{text.data(), text.data() + text.size()};
    EXPECT_EQ(to_argument(read_element(all), block(10)).text, (std::string_view{"\0\n;\"x", 5}));
    text = "#0 a;b ";
    all = {text.data(), text.data() + text.size()};
    EXPECT_EQ(to_argument(read_element(all), block(10)).text, " a;b ");
    EXPECT_EQ(refused("#210abc", block(10)), -161);
    EXPECT_EQ(refused("#3x", block(10)), -161);
    EXPECT_EQ(refused("#15abcde", block(4)), -223);
}

TEST(ScpiValueTest, WrongKindHasItsOwnError) {
    const std::vector<Parameter> kinds{number("", 0, 1), boolean(), choice("A|B"), string(), block(9)};
    const std::vector<std::pair<std::string, std::vector<int>>> cases{{"1", {0, 0, -128, -128, -128}},
                                                                      {"A", {-141, -104, 0, -148, -148}},
                                                                      {"\"A\"", {-158, -158, -158, 0, -158}},
                                                                      {"#11A", {-168, -168, -168, -168, 0}}};
    for (const auto& [text, codes] : cases)
        for (std::size_t i = 0; i < kinds.size(); ++i)
            EXPECT_EQ(refused(text, kinds[i]), codes[i]) << text << " " << i;
}

}  // namespace
}  // namespace shaker::scpi
