// shaker-mock from outside: command lines in, lines of JSON out.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>
#include <vector>

#include "tests/support/devices/mock_cameras.hpp"
#include "tests/support/program.hpp"

namespace shaker::test {
namespace {

std::vector<nlohmann::json> answers(const std::string& commands, Outcome* outcome = nullptr) {
    EXPECT_EQ(private_network(), "");
    const Outcome o = Program{"shaker-mock", "", fresh_folder(), commands}.wait(60);
    std::vector<nlohmann::json> all;
    std::istringstream lines{o.out};
    for (std::string line; std::getline(lines, line);) all.push_back(nlohmann::json::parse(line));
    if (outcome != nullptr) *outcome = o;
    return all;
}

TEST(ShakerMockTest, PrintsRigFileAnswersCountsLeavesNothing) {
    Outcome o;
    const auto all = answers("counts\ndrift 1 0 1 20\n\nquit\n", &o);
    EXPECT_EQ(o.status, 0) << o.err;
    ASSERT_EQ(all.size(), 3U) << o.out;
    const std::filesystem::path rig = all[0].at("rig").get<std::string>();
    EXPECT_EQ(rig.filename(), "rig.toml");
    EXPECT_FALSE(std::filesystem::exists(rig.parent_path())) << "its folder goes with it";
    EXPECT_EQ(all[1].at("counts").at("dac").at("streams"), 0);
    EXPECT_EQ(all[1].at("counts").at("camera").at("side").at("transmitted"), 0);
    EXPECT_TRUE(all[2].at("v_D_mps").is_null()) << "nothing was played";
}

TEST(ShakerMockTest, EveryFaultIsUnderstood) {
    const auto all = answers(
        "dac underrun\ndac stall 0.1\ndac unplug\ndac plug\naccelerometer silence 0.1\n"
        "accelerometer freeze 0.1\naccelerometer drop 5\naccelerometer disconnect\naccelerometer error -110\n"
        "accelerometer shift -0.5\naccelerometer jitter 0.001\ncamera top lose 0.5\ncamera side stall 0.1\n"
        "camera top drop 3\ncamera top shift 0.1\ncamera side unplug\ncamera side plug\n");
    ASSERT_EQ(all.size(), 18U);
    for (const auto& answer : all) EXPECT_TRUE(answer.at("ok")) << answer;
}

TEST(ShakerMockTest, UnknownCommandIsAnsweredWithKnownOnes) {
    const struct {
        const char* line;
        std::vector<const char*> words;
    } cases[] = {{"frobnicate", {"\"frobnicate\"", "accelerometer, camera, dac, line, mixer, counts, drift"}},
                 {"dac melt", {"\"melt\"", "plug, stall, underrun, unplug"}},
                 {"dac stall", {"SECONDS", "at its end"}},
                 {"dac stall -1", {"SECONDS = \"-1\"", "0.001 to 3600"}},
                 {"dac stall 1x", {"SECONDS = \"1x\""}},
                 {"camera left lose 0.1", {"\"left\"", "\"top\", \"side\""}},
                 {"camera top lose 2", {"SHARE = \"2\"", "0 to 1"}},
                 {"dac underrun now", {"\"now\" is one word too many"}}};
    std::string commands;
    for (const auto& c : cases) commands += std::string{c.line} + "\n";
    const auto all = answers(commands);
    ASSERT_EQ(all.size(), 1 + std::size(cases));
    for (std::size_t i = 0; i < std::size(cases); ++i) {
        EXPECT_FALSE(all[i + 1].at("ok")) << cases[i].line;
        for (const char* word : cases[i].words)
            EXPECT_NE(all[i + 1].at("error").get<std::string>().find(word), std::string::npos)
                << all[i + 1] << " without " << word;
    }
}

}  // namespace
}  // namespace shaker::test
