// What the programs print: results, errors for wrong input, and the content of a recording with pictures.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/support/golden.hpp"
#include "tests/support/hdf5_text.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/program.hpp"

namespace shaker {
namespace {

// The lines "$ command" of the kept text are run one after the other in an empty folder.
class GoldenPrintedTest : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Texts, GoldenPrintedTest, testing::Values("results", "recordings", "errors"),
                         [](const auto& name) { return std::string{name.param}; });

TEST_P(GoldenPrintedTest, IsTheKeptText) {
    const std::string file = std::string{"printed/"} + GetParam() + ".txt";
    const auto folder = test::fresh_folder();
    std::string all;
    for (const std::string& line : test::golden_inputs(file, {"$ "}))
        all += test::printed_by(line.substr(2), folder);
    test::expect_golden(file, test::without_place_and_time(all, folder));
}

// The run that made tests/golden/recordings/walk.tar.gz.
TEST(GoldenRecordingTest, EveryByteOfARunWithPictures) {
    const auto folder = test::fresh_folder();
    const test::Outcome made =
        test::shakerd("run --scene '" + test::source_dir() +
                          "/tests/golden/recordings/walk.toml' --no-identify --open-loop --settle 4 "
                          "--periods 4 --frames region -o walk.nxs",
                      folder);
    ASSERT_EQ(made.status, 0) << made.err;
    std::vector<std::filesystem::path> files{folder / "walk.nxs"};
    for (const auto& entry : std::filesystem::directory_iterator{folder / "walk.frames"})
        files.push_back(entry.path());
    std::ranges::sort(files);
    std::string all;
    for (const std::filesystem::path& file : files)
        all += "== " + file.lexically_relative(folder).string() + '\n' + test::text_of_hdf5(file);
    test::expect_golden("recording/walk.txt", test::without_place_and_time(all, folder));
}

}  // namespace
}  // namespace shaker
