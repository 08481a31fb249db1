// shakerd without its module shaker_codecs.so.
#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/paths.hpp"
#include "tests/support/program.hpp"

namespace shaker::commands {
namespace {

class CodecsTest : public testing::Test {
protected:
    std::filesystem::path folder_ = test::fresh_folder();

    /// A copy of shakerd in an empty folder.
    test::Outcome lonely_shakerd(const std::string& arguments) {
        std::filesystem::copy_file(test::build_dir() + "/shakerd", folder_ / "shakerd");
        const auto name = std::filesystem::relative(folder_ / "shakerd", test::build_dir());
        return test::Program{name.string(), arguments, folder_}.wait();
    }
};

TEST_F(CodecsTest, NamesMissingModuleWhenItIsNeeded) {
    std::filesystem::create_directories(folder_ / "pictures");
    std::ofstream{folder_ / "pictures" / "1.pgm"} << "P5 2 1 255\nab";
    std::ofstream{folder_ / "session.toml"} << R"(title = "one picture"
[[camera]]
name = "top"
file = "pictures"
frame_rate_hz = 20.0
first_exposure_s = 0.0
mm_per_px = 1.0
along = [1.0, 0.0]
[[camera.target]]
name = "dot1"
kind = "dots"
diameter_mm = 20.0
roi_px = [0, 0, 2, 1]
polarity = "dark"
)";
    const test::Outcome o = lonely_shakerd("track session.toml");
    EXPECT_EQ(o.status, 3) << o.err;
    EXPECT_NE(o.err.find("shaker_codecs.so"), std::string::npos) << o.err;
}

TEST_F(CodecsTest, RunsWithoutModuleWhereItIsNotNeeded) {
    const test::Outcome o = lonely_shakerd("--help");
    EXPECT_EQ(o.status, 0) << o.err;
}

}  // namespace
}  // namespace shaker::commands
