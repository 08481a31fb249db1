// What a user reads after a wrong input: the thing, its value, what is allowed, and the next step.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "tests/support/program.hpp"

namespace shaker::commands {
namespace {

using test::Outcome;

struct Wrong {
    const char* program;
    const char* arguments;
    int status;
    std::vector<const char*> words;  // in standard error
};

class MessagesTest : public testing::Test {
protected:
    void SetUp() override {
        const auto write = [this](const char* name, const std::string& text) {
            std::ofstream{folder_ / name, std::ios::binary} << text;
        };
        write("wlaker.toml", "wlaker = 1\n");
        write("zeros.toml", std::string(100, '\0'));
        write("scene.toml",
              "[top]\npositions = 1\nframe_rate_hz = 200\n[side]\npositions = 1\nframe_rate_hz = 200\n");
        write("pic.png", "\x89PNG\r\n");
        const Outcome made =
            test::Program{"shakerd", "run --scene scene.toml --no-identify --periods 10 -o run.nxs", folder_}
                .wait(60);
        ASSERT_EQ(made.status, 0) << made.err;
    }

    const std::filesystem::path folder_ = test::fresh_folder();
};

TEST_F(MessagesTest, NameTheThingTheValueAndTheNextStep) {
    const std::vector<Wrong> table{
        {"shakerd",
         "run --scene wlaker.toml",
         2,
         {"wlaker.toml:1", "wlaker: unknown key", "did you mean \"walker\"?"}},
        {"shakerd",
         "run --settings zeros.toml",
         2,
         {"zeros.toml", "a binary file", "expected settings as text (TOML)"}},
        {"shakerd",
         "run --settings run.nxs",
         2,
         {"run.nxs", "HDF5", "a recording", "expected settings as text (TOML)"}},
        {"shakerd",
         "run -o /nonexistent/x.nxs",
         2,
         {"/nonexistent/x.nxs", "there is no folder /nonexistent", "mkdir"}},
        {"shakerd", "run --phi 800deg", 2, {"--phi \"800deg\"", "allowed: -720 to 720 deg"}},
        {"shakerd", "run --gamma 200g", 2, {"--gamma \"200g\"", "allowed: 0.00102041 to 100 g"}},
        {"shakerd",
         "run --gamma 9g",
         2,
         {"exceeds the limits", "at most gamma", " g) is allowed for this shape"}},
        {"shakerd",
         "run --scene scene.toml --no-identify --periods 5 --gamma 0.7",
         0,
         {"gamma 0.7 m/s^2 is 0.0714 g", "--gamma 0.7g"}},
        {"shakerd", "replay .", 2, {".: is a folder; expected a recording (FILE.nxs)"}},
        {"shakerd", "replay pic.png", 2, {"pic.png: not an HDF5 file"}},
        {"shakerd",
         "replay --set from_s=500 run.nxs",
         2,
         {"from_s=500: expected 0 to ", " s, which is to_s"}},
        {"shakerd", "nonsense --help", 2, {"\"nonsense\" is not a command", "shakerd --help"}},
        {"shakerd", "nonsense", 2, {"\"nonsense\" is not a command", "shakerd --help"}},
        {"shakerctl", "nonsense --help", 2, {"\"nonsense\" is not a command", "shakerctl --help"}},
        {"shakerctl",
         "--at 127.0.0.1:1 status",
         69,
         {"127.0.0.1:1: Connection refused", "is \"shakerd serve\" running?", "--at or SHAKERD_URL"}},
    };
    for (const Wrong& wrong : table) {
        const Outcome o = test::Program{wrong.program, wrong.arguments, folder_}.wait(60);
        EXPECT_EQ(o.status, wrong.status) << wrong.arguments << '\n' << o.err;
        for (const char* word : wrong.words)
            EXPECT_NE(o.err.find(word), std::string::npos)
                << wrong.arguments << ": no \"" << word << "\" in\n"
                << o.err;
    }
}

TEST_F(MessagesTest, HelpOfEveryCommandIsStillAnswered) {
    for (const char* arguments : {"--help", "run --help", "replay --help"}) {
        const Outcome o = test::Program{"shakerd", arguments, folder_}.wait(60);
        EXPECT_EQ(o.status, 0) << arguments << o.err;
        EXPECT_FALSE(o.out.empty());
    }
}

}  // namespace
}  // namespace shaker::commands
