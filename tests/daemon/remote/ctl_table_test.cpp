#include <gtest/gtest.h>
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cstdio>
#include <iterator>
#include <map>
#include <set>
#include <sstream>

#include "daemon/manual/help.hpp"
#include "daemon/orders/row.hpp"
#include "daemon/remote/ctl/outcome.hpp"
#include "daemon/remote/ctl/state_text.hpp"
#include "daemon/remote/ctl/table.hpp"
#include "daemon/remote/web/state_json.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/program.hpp"

namespace shaker::ctl {
namespace {

using manual::Argument;
using manual::Command;

using Words = std::multiset<std::string>;

Words words_of(const std::string& text) {
    std::istringstream in{text};
    return {std::istream_iterator<std::string>{in}, {}};
}

std::string plain(std::string roff) {  // as displayed
    for (const auto& [sign, shown] : {std::pair{"\\fB", ""}, std::pair{"\\fI", ""}, std::pair{"\\fP", ""},
                                      std::pair{"\\-", "-"}, std::pair{"\\(ha", "^"}, std::pair{"\n", " "}})
        for (auto at = roff.find(sign); at != std::string::npos; at = roff.find(sign))
            roff.replace(at, std::string_view{sign}.size(), shown);
    return roff;
}

// Output of a command, which must succeed.
std::string output_of(const std::string& command) {
    FILE* pipe = ::popen(command.c_str(), "r");
    std::string out;
    for (int c = 0; (c = std::fgetc(pipe)) != EOF;) out += static_cast<char>(c);
    EXPECT_EQ(::pclose(pipe), 0) << command;
    return out;
}

void expect_in_all_texts(const Command& command, const std::string& page) {
    const std::string name{command.name};
    EXPECT_TRUE(words_of(help(program())).contains(name)) << name;
    EXPECT_NE(page.find(".TP " + name + " "), std::string::npos) << name;
    EXPECT_NE(page.find(sentences(command)), std::string::npos) << name;
    const Words own = words_of(help(program(), &command));
    for (const Argument& a : command.arguments) {
        EXPECT_TRUE(own.contains(std::string{a.name})) << name << " " << a.name;
        EXPECT_NE(page.find(a.help), std::string::npos) << name << " " << a.name;
        EXPECT_EQ(a.help.find('\n'), std::string::npos);
    }
}

TEST(CtlTableTest, EveryRowIsInHelpAndManualPage) {
    const std::string page = plain(manual_page(program()));
    for (const Command& command : program().commands) expect_in_all_texts(command, page);
}

TEST(CtlTableTest, EveryExitStatusIsInHelpManualPageAndReadme) {
    const std::string page = plain(manual_page(program())), text = help(program());
    const std::string readme = output_of("sed -n '/^| exit status of `shakerctl`/,/^$/p' '" +
                                         test::source_dir() + "/daemon/remote/README.md'");
    for (const manual::ExitStatus& s : exit_statuses) {
        const std::string number = std::to_string(s.number), meaning{s.meaning};
        EXPECT_NE(text.find(number + "  " + meaning + "\n"), std::string::npos) << number;
        EXPECT_NE(readme.find("\n| " + number + " | " + meaning), std::string::npos) << readme;
        EXPECT_NE(page.find(".TP " + number + " " + meaning), std::string::npos) << number;
    }
}

// A line "| `name`, `name` | keys |" of the page for each order.
TEST(CtlTableTest, EveryOrderIsInTheReadmeWithItsKeys) {
    std::istringstream page{output_of("cat '" + test::source_dir() + "/daemon/remote/README.md'")};
    std::map<std::string, std::string> keys;  // by name
    for (std::string line; std::getline(page, line);) {
        const auto middle = line.find(" | ");
        if (!line.starts_with("| `") || middle == std::string::npos) continue;
        std::istringstream names{line.substr(2, middle - 2)};
        for (std::string name; names >> name;)
            keys[name.substr(0, name.rfind('`') + 1)] = line.substr(middle);
    }
    for (const orders::Row& row : orders::rows()) {
        const auto found = keys.find(fmt::format("`{}`", row.name));
        ASSERT_NE(found, keys.end()) << row.name;
        for (const orders::Field& field : row.fields) {
            const bool elsewhere = found->second.find("as `campaign`") != std::string::npos ||
                                   found->second.find("keys of `drive`") != std::string::npos;
            EXPECT_TRUE(elsewhere || found->second.find(fmt::format("`{}`", field.key)) != std::string::npos)
                << row.name << ' ' << field.key;
        }
    }
}

TEST(CtlTableTest, TheStatesAreThoseOfTheDaemon) {
    std::set<std::string> daemon;
    service::BenchState state;
    for (int k = 0; k < run::run_states; ++k) {
        state.state = static_cast<run::RunState>(k);
        for (const bool yes : {false, true}) {
            state.armed = state.measuring = yes;
            daemon.insert(web::word_of(state));
        }
    }
    EXPECT_EQ(daemon, (std::set<std::string>{state_words.begin(), state_words.end()}));
}

TEST(CtlTableTest, TheManualPagesAreCleanAndFound) {
    for (const auto& [name, about] :
         {std::pair{"shakerctl.1", "shakerctl - commands to a shaker bench on call"},
          std::pair{"shakerd.8",
                    "shakerd - shaker controller and data acquisition for vibration transport"}}) {
        const std::string page = std::string{test::build_dir() + "/"} + name;
        EXPECT_EQ(output_of("LC_ALL=C.UTF-8 MANWIDTH=80 man --warnings -l '" + page + "' 2>&1 >/dev/null"),
                  "");
        EXPECT_EQ(output_of("mandoc -Tlint -Wstyle '" + page + "'"), "");
        EXPECT_EQ(output_of("lexgrog '" + page + "'"), page + ": \"" + about + "\"\n");
    }
    EXPECT_EQ(output_of("cat '" + test::build_dir() + "/shakerctl.1'"), manual_page(program()));
    EXPECT_EQ(output_of("cat '" + test::build_dir() + "/shakerd.8'"),
              output_of("'" + test::build_dir() + "/shakerd' manual"));
}

TEST(CtlTableTest, EveryOptionInTheDaemonsHelpIsInItsManualPage) {
    const std::string page = plain(output_of("cat '" + test::build_dir() + "/shakerd.8'"));
    std::istringstream text{output_of("'" + test::build_dir() + "/shakerd' --help")};
    std::string line;
    while (std::getline(text, line) && line != "Commands:") continue;
    int commands = 0;
    while (std::getline(text, line) && line.starts_with("  ")) {
        const std::string command = *words_of(line.substr(0, line.find("  ", 2))).begin();
        ++commands;
        EXPECT_NE(page.find(".TP " + command + " "), std::string::npos) << command;
        std::istringstream own{output_of("'" + test::build_dir() + "/shakerd' " + command + " --help")};
        for (std::string option; std::getline(own, option);)
            if (option.starts_with("  -") && !option.starts_with("  -h")) {
                EXPECT_NE(page.find(".TP " + option.substr(2, option.find_first_of(" ,", 2) - 2)),
                          std::string::npos)
                    << option;
            }
    }
    EXPECT_GE(commands, 10);
}

}  // namespace
}  // namespace shaker::ctl
