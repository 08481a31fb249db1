// Text of files and clients on a terminal.
#include "drivers/text/printable.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace shaker {
namespace {

TEST(PrintableTest, EscapesOnlyControlCharacters) {
    EXPECT_EQ(printable("14.7 m/s\xc2\xb2 \xe2\x82\xac \xf0\x9f\x98\x80"),
              "14.7 m/s\xc2\xb2 \xe2\x82\xac \xf0\x9f\x98\x80");
    EXPECT_EQ(printable("\xff\xc2 \xc0\x80 \xed\xa0\x80 \xe2\x82"),
              "\\xff\\xc2 \\xc0\\x80 \\xed\\xa0\\x80 \\xe2\\x82");
    EXPECT_EQ(printable("\xe2\x80\xa8\xe2\x81\xa6\xd8\x9c\x7f\t"), "\\u2028\\u2066\\u061c\\u007f\\x09");
    EXPECT_EQ(printable("a\tb\r\n", true), "a\tb\\x0d\n");
}

TEST(PrintableTest, EscapesEveryControlOfC0AndC1) {
    for (unsigned code = 0; code < 0xa0; ++code) {
        if (code >= 0x20 && code < 0x7f) continue;
        std::string text;
        if (code >= 0x80) text += static_cast<char>(0xc2);
        text += static_cast<char>(code);
        for (const char c : printable(text)) EXPECT_TRUE(c >= ' ' && c <= '~') << code;
        // A lone byte of the old 8-bit sets, which some terminals still obey.
        for (const char c : printable(std::string{static_cast<char>(code)}))
            EXPECT_TRUE(c >= ' ' && c <= '~');
    }
}

TEST(PrintableTest, KeepsJson) {
    const nlohmann::json j =
        "a\x1b[2J \xc2\x9b"
        "b \x7f \xe2\x80\xae";
    EXPECT_EQ(nlohmann::json::parse(printable(j.dump())), j);
}

TEST(PrintableTest, FindsCharacterThatIsCut) {
    const std::string text = "m/s\xc2\xb2 \xe2\x82\xac \xf0\x9f\x98\x80";
    EXPECT_EQ(unfinished_bytes(text), 0U);
    EXPECT_EQ(unfinished_bytes(""), 0U);
    for (std::size_t cut = 1; cut <= 3; ++cut)
        EXPECT_EQ(unfinished_bytes(text.substr(0, text.size() - cut)), 4 - cut);
    EXPECT_EQ(unfinished_bytes("a\xb2"), 0U);
    EXPECT_EQ(unfinished_bytes("\xff"), 0U);
}

}  // namespace
}  // namespace shaker
