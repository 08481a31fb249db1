// The help of every program and command, as printed.
#include <gtest/gtest.h>

#include <string>

#include "daemon/commands/table.hpp"
#include "daemon/remote/ctl/table.hpp"
#include "tests/support/golden.hpp"
#include "tests/support/program.hpp"

namespace shaker {
namespace {

void expect_help(const manual::Program& program) {
    const std::string name{program.name};
    const auto folder = test::fresh_folder();
    std::string all = test::printed_by(name + " --help", folder);
    for (const manual::Command& command : program.commands)
        all += test::printed_by(name + ' ' + std::string{command.name} + " --help", folder);
    all += test::printed_by(name + " --version", folder);
    test::expect_golden("help/" + name + ".txt", test::without_place_and_time(all, folder));
}

TEST(GoldenHelpTest, EveryCommandOfShakerd) { expect_help(commands::program()); }

TEST(GoldenHelpTest, EveryCommandOfShakerctl) { expect_help(ctl::program()); }

TEST(GoldenHelpTest, TheMockBench) {
    const auto folder = test::fresh_folder();
    test::expect_golden("help/shaker-mock.txt",
                        test::without_place_and_time(test::printed_by("shaker-mock --help", folder), folder));
}

}  // namespace
}  // namespace shaker
