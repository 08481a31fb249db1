#include <gtest/gtest.h>

#include "daemon/commands/run.hpp"
#include "daemon/commands/table.hpp"
#include "daemon/manual/help.hpp"
#include "daemon/manual/parser.hpp"
#include "drivers/errors.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/program.hpp"

namespace shaker::commands {
namespace {

manual::ParsedLine parsed(std::vector<const char*> words) {
    words.insert(words.begin(), "shakerd");
    return manual::parse(program(), static_cast<int>(words.size()), words.data());
}

std::string refusal(const std::vector<const char*>& words) {
    try {
        parsed(words);
    } catch (const InputError& e) {
        return e.what();
    }
    return "accepted";
}

void expect_in(const std::string& text, const std::vector<std::string_view>& parts) {
    for (const std::string_view part : parts)
        EXPECT_NE(text.find(part), std::string::npos) << "\"" << part << "\" is not in: " << text;
}

TEST(CommandTableTest, EveryRowHasHelpAndAHandler) {
    for (const manual::Command& command : program().commands) {
        EXPECT_NE(command.act, nullptr) << command.name;
        expect_in(help(program()), {command.name, command.summary});
        EXPECT_FALSE(command.summary.ends_with('.')) << command.name;
        const std::string own = help(program(), &command);
        for (const manual::Argument& a : command.arguments) {
            expect_in(own, {a.name});
            EXPECT_FALSE(a.help.ends_with('.')) << command.name << " " << a.name;
        }
    }
}

TEST(CommandTableTest, HelpFitsOnAHundredColumns) {
    for (const manual::Command& command : program().commands) {
        std::istringstream lines{help(program(), &command)};
        for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 101U) << line;
    }
}

TEST(CommandTableTest, EveryStandardValueIsAllowed) {
    for (const manual::Command& command : program().commands)
        for (const manual::Argument& a : command.arguments) {
            manual::Values values{program(), command};
            if (a.standard.empty() || a.must_exist) continue;
            EXPECT_NO_THROW(values.add(a, {std::string{a.standard}})) << command.name << " " << a.name;
        }
}

TEST(CommandTableTest, StandardValuesOfRunAreThoseOfTheRun) {
    const manual::ParsedLine line = parsed({"run"});
    const run::RunOptions standard, options = run_options(line.values);
    EXPECT_EQ(line.values.whole("--periods"), standard.plan.periods);
    EXPECT_EQ(line.values.whole("--settle"), standard.plan.settle);
    EXPECT_EQ(line.values.text("--rig"), standard.rig);
    EXPECT_EQ(line.values.number("--gamma"), standard.drive.gamma);
    EXPECT_EQ(line.values.number("--phi"), standard.drive.phi);
    EXPECT_EQ(line.values.number("--rho"), standard.drive.rho);
    EXPECT_EQ(line.values.number("--frequency"), standard.drive.frequency);
    EXPECT_EQ(recorded::kept_pictures_named(line.values.text("--frames")), standard.pictures);
    EXPECT_EQ(run_settings_text(options), run_settings_text(standard));
    EXPECT_EQ(options.trips, standard.trips);
}

TEST(CommandTableTest, OptionsOfRunAreTaken) {
    const run::RunOptions o = run_options(
        parsed({"run", "--gamma", "1.5g", "--phi", "-35deg", "--periods", "7", "--settle", "3", "-o", "x.nxs",
                "--frames", "off", "--no-identify", "--open-loop", "--threads", "--real-time", "--json"})
            .values);
    EXPECT_DOUBLE_EQ(o.drive.gamma, 1.5 * paper_g);
    EXPECT_NEAR(o.drive.phi, -0.6108652, 1e-7);
    EXPECT_EQ(o.plan.periods, 7);
    EXPECT_EQ(o.plan.settle, 3);
    EXPECT_EQ(o.out, "x.nxs");
    EXPECT_EQ(o.pictures, recorded::KeptPictures::off);
    EXPECT_FALSE(o.identify || o.closed_loop);
    EXPECT_TRUE(o.threads && o.real_time && o.json);
}

TEST(CommandTableTest, ListsEndBeforeThePositionalArgument) {
    const manual::Values replay =
        parsed({"replay", "--set", "a=1", "--set", "b=2", "--from", "raw", "x.nxs"}).values;
    EXPECT_EQ(replay.texts("--set"), (std::vector<std::string>{"a=1", "b=2"}));
    EXPECT_EQ(replay.text("FILE"), "x.nxs");
    const manual::Values exported = parsed({"export", "x.nxs", "--what", "tracks,drive"}).values;
    EXPECT_EQ(exported.texts("--what"), (std::vector<std::string>{"tracks", "drive"}));
    EXPECT_EQ(parsed({"export", "x.nxs"}).values.texts("--what"), std::vector<std::string>{"all"});
}

TEST(CommandTableTest, PredictJsonTakesOptionalFile) {
    EXPECT_TRUE(parsed({"predict", "--json"}).values.has("--json"));
    EXPECT_EQ(parsed({"predict", "--json"}).values.text("--json"), "");
    EXPECT_EQ(parsed({"predict", "--json", "cases.json"}).values.text("--json"), "cases.json");
    EXPECT_FALSE(parsed({"predict"}).values.has("--json"));
}

TEST(CommandTableTest, RefusalsNameOptionValueAndRange) {
    expect_in(refusal({"run", "--gamma", "2000g"}), {"--gamma", "2000g", "0.00102041 to 100 g"});
    expect_in(refusal({"run", "--periods", "1"}), {"--periods", "\"1\"", "3 to 1000000"});
    expect_in(refusal({"run", "--settle", "x"}), {"--settle", "\"x\"", "0 to 10000"});
    expect_in(refusal({"run", "--frames", "most"}), {"--frames", "most", "off, first-second, region, full"});
    expect_in(refusal({"run", "--trips", "/no/such"}), {"--trips", "/no/such", "no such folder"});
    expect_in(refusal({"run", "--gama", "1g"}), {"--gama", "shakerd run --help"});
    expect_in(refusal({"run", "--gamma"}), {"--gamma", "expected one value"});
    expect_in(refusal({"run", "--gamma", "3", "bananas"}), {"--gamma \"3 bananas\"", "units"});
    expect_in(refusal({"serve", "--scpi-port", "70000"}), {"--scpi-port", "70000", "0 to 65535"});
    expect_in(refusal({"serve", "--settings", "/no/such"}), {"--settings", "/no/such", "no such file"});
    expect_in(refusal({"check", "--level", "0.3"}), {"--level", "0.3", "0 to 0.2"});
    expect_in(refusal({"replay"}), {"FILE is required"});
    expect_in(refusal({"dance"}), {"\"dance\" is not a command", "shakerd --help"});
    expect_in(refusal({}), {"expected a command"});
}

TEST(CommandTableTest, HelpOfACommandNamesItsExitStatuses) {
    expect_in(parsed({"replay", "--help"}).text, {"Usage: shakerd replay [OPTIONS] FILE", "  4  replay:"});
    EXPECT_EQ(parsed({"predict", "-h"}).text.find("  4  replay"), std::string::npos);
    EXPECT_EQ(parsed({"--version"}).text, "shakerd " SHAKER_VERSION "\n");
    EXPECT_EQ(parsed({"run", "--version"}).text, "shakerd " SHAKER_VERSION "\n");
}

TEST(CommandTableTest, TheManualPageHasEveryRow) {
    const std::string page = manual_page(program());
    for (const manual::Command& command : program().commands)
        expect_in(page, {".TP\n\\fB" + std::string{command.name} + "\\fP"});
}

std::string output_of(const std::string& command) {
    FILE* pipe = ::popen(command.c_str(), "r");
    std::string out;
    for (int c = 0; (c = std::fgetc(pipe)) != EOF;) out += static_cast<char>(c);
    EXPECT_EQ(::pclose(pipe), 0) << command;
    return out;
}

TEST(CommandTableTest, BashCompletesCommandsOptionsWordsAndFiles) {
    const auto folder = test::fresh_folder();
    std::ofstream{folder / "run.nxs"};
    const auto bash = [&](const std::string& words) {
        return output_of("cd '" + folder.string() + "' && PATH='" + test::build_dir() +
                         "':$PATH bash -c 'source " + test::source_dir() +
                         "/daemon/manual/completion.bash; COMP_WORDS=(" + words +
                         "); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _shaker_completion ${COMP_WORDS[0]}; "
                         "echo ${COMPREPLY[@]}'");
    };
    EXPECT_EQ(bash("shakerd ser"), "serve\n");
    EXPECT_EQ(bash("shakerd run --frames \"\""), "off first-second region full\n");
    EXPECT_EQ(bash("shakerd run --gam"), "--gamma\n");
    EXPECT_EQ(bash("shakerd replay ru"), "run.nxs\n");
    EXPECT_EQ(bash("shakerd export -o /us"), "/usr\n");
    EXPECT_EQ(bash("shakerctl sta"), "status start\n");
    EXPECT_EQ(bash("shakerctl set --ga"), "--gamma\n");
}

}  // namespace
}  // namespace shaker::commands
