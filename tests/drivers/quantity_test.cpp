#include "drivers/quantity.hpp"

#include <gtest/gtest.h>

#include <clocale>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "drivers/errors.hpp"

namespace shaker {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr Range any{-infinity, infinity};

std::string refusal(std::string_view text, Dimension dimension, Range allowed = any) {
    try {
        const double value = parse_quantity("--gamma", text, dimension, allowed);
        return "accepted as " + to_text(value);
    } catch (const InputError& error) {
        return error.what();
    }
}

struct Case {
    std::string_view text;
    Dimension dimension;
    double si;
};

TEST(QuantityTest, UnitsBecomeSiToTheLastBit) {
    constexpr double pi = std::numbers::pi;
    const Case cases[] = {
        {"1.5g", Dimension::acceleration, 1.5 * 9.8},
        {"14.7 m/s^2", Dimension::acceleration, 14.7},
        {"250mm/s^2", Dimension::acceleration, 0.25},
        {"35deg", Dimension::angle, 35 * pi / 180},
        {"-35 deg", Dimension::angle, -35 * pi / 180},
        {"35°", Dimension::angle, 35 * pi / 180},
        {"0.61rad", Dimension::angle, 0.61},
        {"0.61", Dimension::angle, 0.61},
        {"20Hz", Dimension::frequency, 20},
        {"0.02kHz", Dimension::frequency, 20},
        {"50ms", Dimension::time, 0.05},
        {"  300 us ", Dimension::time, 300e-6},
        {"1e3 ns", Dimension::time, 1e-6},
        {"2min", Dimension::time, 120},
        {"27.8 mm/s", Dimension::velocity, 27.8 / 1e3},
        {"+0.5", Dimension::ratio, 0.5},
        {"50%", Dimension::ratio, 0.5},
    };
    for (const auto& [text, dimension, si] : cases)
        EXPECT_EQ(parse_quantity("x", text, dimension, any), si) << text;
}

TEST(QuantityTest, RefusesWrongUnitAndListsKnownOnes) {
    const std::string message = refusal("20Hz", Dimension::acceleration, {0, 100});
    EXPECT_NE(message.find("--gamma \"20Hz\""), std::string::npos) << message;
    EXPECT_NE(message.find("unknown unit \"Hz\""), std::string::npos) << message;
    EXPECT_NE(message.find("m/s^2, mm/s^2, g"), std::string::npos) << message;
    EXPECT_NE(message.find("0 to 100 m/s^2"), std::string::npos) << message;
}

TEST(QuantityTest, ACommaAloneIsADecimalPoint) {
    const Case cases[] = {
        {"0,5", Dimension::acceleration, 0.5},
        {"1,5g", Dimension::acceleration, 1.5 * 9.8},
        {"-3,5 deg", Dimension::angle, -3.5 * std::numbers::pi / 180},
        {"0,113", Dimension::ratio, 0.113},
        {"+1,5e1 Hz", Dimension::frequency, 15},
        {"50,5 %", Dimension::ratio, 50.5 / 100},
    };
    for (const auto& [text, dimension, si] : cases)
        EXPECT_EQ(parse_quantity("x", text, dimension, any), si) << text;
    for (const std::string_view text :
         {"1,234,567", "1,5.2", "1.5,2", ",5", "1,", "-,5g", "1,g", "1, 5", ",", "1,,5"})
        EXPECT_NE(refusal(text, Dimension::acceleration).find("decimal comma"), std::string::npos)
            << refusal(text, Dimension::acceleration);
}

TEST(QuantityTest, UnitsKeepTheirCase) {
    EXPECT_EQ(parse_quantity("gamma", "1.5G", Dimension::acceleration, any), 1.5 * 9.8) << "as in SCPI";
    EXPECT_NE(refusal("1hz", Dimension::frequency).find("unknown unit \"hz\""), std::string::npos);
    EXPECT_EQ(parse_quantity("f", "1mHz", Dimension::frequency, any), 1e-3);
}

TEST(QuantityTest, RefusesNonFiniteNumbers) {
    for (const std::string_view text :
         {"", " ", "g", "fast", "nan", "inf", "-inf", "nan g", "1e999", "--1", "+-1"})
        EXPECT_EQ(refusal(text, Dimension::acceleration).find("--gamma \""), 0U) << text;
    EXPECT_NE(refusal("0x10", Dimension::ratio).find("unknown unit"), std::string::npos);
    EXPECT_NE(refusal("1 2", Dimension::ratio).find("unknown unit \"2\""), std::string::npos);
}

TEST(QuantityTest, AllowsBothEndsOfTheRange) {
    const Range allowed{0.1, 5000};
    EXPECT_EQ(parse_quantity("f", "5kHz", Dimension::frequency, allowed), 5000);
    EXPECT_EQ(parse_quantity("f", "0.1", Dimension::frequency, allowed), 0.1);
    EXPECT_NE(refusal("5.001kHz", Dimension::frequency, allowed).find("allowed: 0.0001 to 5 kHz"),
              std::string::npos);
    EXPECT_NE(refusal("-20Hz", Dimension::frequency, allowed).find("out of range"), std::string::npos);
}

TEST(QuantityTest, IgnoresDecimalCommaLocale) {
    const std::string before = std::setlocale(LC_ALL, nullptr);
    for (const char* name : {"de_DE.UTF-8", "fr_FR.UTF-8", "C.UTF-8"}) {
        if (std::setlocale(LC_ALL, name) == nullptr) continue;
        EXPECT_EQ(parse_quantity("x", "1.5", Dimension::ratio, any), 1.5) << name;
        EXPECT_EQ(to_text(1.5), "1.5") << name;
    }
    std::setlocale(LC_ALL, before.c_str());
}

TEST(QuantityTest, ANumberAsTextReadsBackTheSame) {
    for (const double value : {0.1, 1.0 / 3, -1e-300, 6.02214076e23, 35 * std::numbers::pi / 180})
        EXPECT_EQ(std::stod(to_text(value)), value);
    EXPECT_EQ(to_text(6e-4), "0.0006");
    EXPECT_EQ(to_text(0.0), "0");
    EXPECT_EQ(to_text(Range{0.1, 5000}), "0.1 to 5000");
    EXPECT_EQ(to_text(Range{0, infinity}), "at least 0");
    EXPECT_EQ(to_text(Range{-infinity, 5}), "at most 5");
    EXPECT_EQ(to_text(any), "any number");
}

}  // namespace
}  // namespace shaker
