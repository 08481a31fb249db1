// Which lines are right answers to the queries of an SCPI client.
#include "tests/orders/scpi_answers.hpp"

#include <gtest/gtest.h>

namespace shaker::orders {
namespace {

TEST(ScpiAnswersTest, AnswerHasTheFormOfItsQuery) {
    const auto wrong = [](const char* query, const char* line) {
        ScpiAnswers answers;
        answers.asked(form_of(std::string{query} + "\n"), false);
        return answers.take(line);
    };
    EXPECT_EQ(wrong("READ?", "6.59945473E-03,5.79281516E-07,3.29972737E-04,19,1"), "");
    EXPECT_EQ(wrong("READ?", "9.91E37,9.91E37,9.91E37,0,0"), "");
    EXPECT_NE(wrong("READ?", "9.91E37"), "");
    EXPECT_EQ(wrong("OUTP?", "1"), "");
    EXPECT_NE(wrong("OUTP?", "1;1"), "");
    EXPECT_EQ(wrong("SYST:STAT?", "\"idle\""), "");
    EXPECT_NE(wrong("SYST:STAT?", "idle"), "");
    EXPECT_EQ(form_of("OUTP ON\n"), "");
}

TEST(ScpiAnswersTest, SecondAnswerIsWrong) {
    ScpiAnswers answers;
    answers.asked("1", false);
    EXPECT_EQ(answers.due(), "1");
    EXPECT_EQ(answers.take("1"), "");
    EXPECT_EQ(answers.due(), "");
    EXPECT_EQ(answers.take("1"), "'1' answers no query");
}

TEST(ScpiAnswersTest, AbortDropsWithheldQueries) {
    ScpiAnswers answers;
    answers.asked("paused", false);
    answers.asked("withheld", true);
    answers.asked("abort", false);
    answers.dropped();
    EXPECT_EQ(answers.take("paused"), "");
    EXPECT_EQ(answers.take("abort"), "");
    EXPECT_EQ(answers.due(), "");
}

}  // namespace
}  // namespace shaker::orders
