#include <gtest/gtest.h>

#include "daemon/bench/bench.hpp"
#include "drivers/errors.hpp"

namespace shaker::bench {
namespace {

TEST(ChangedSettingsTest, NamesTopLevelKeysThatDiffer) {
    const std::string file = "g = 9.8\n[dac]\nrate = 1\nof = { a = [1, 2] }\n[[camera]]\nid = 'x'\n";
    EXPECT_TRUE(changed_settings(file, file + "# a comment\n").empty());
    EXPECT_EQ(changed_settings(file, "g = 9.8\n[dac]\nrate = 1\nof = { a = [1, 3] }\n"),
              (std::vector<std::string>{"camera", "dac"}));
    EXPECT_EQ(changed_settings("", file), (std::vector<std::string>{"camera", "dac", "g"}));
}

TEST(ChangedSettingsTest, BrokenTextIsRefused) { EXPECT_THROW(changed_settings("", "g = = 1"), InputError); }

}  // namespace
}  // namespace shaker::bench
