#include "daemon/remote/web/page_files.hpp"

#include <gtest/gtest.h>

#include <string>

#include "tests/support/paths.hpp"

namespace shaker::web {
namespace {

TEST(PageFilesTest, ProgramHasTheBundleToTheByte) {
    const std::string bundle = test::source_dir() + "/daemon/remote/panel/bundle";
    const auto of_program = read_page({}), of_folder = read_page(bundle);
    ASSERT_EQ(of_program.size(), 3U);
    ASSERT_EQ(of_folder.size(), 3U);
    for (const auto& [path, file] : of_program) {
        EXPECT_TRUE(file.content == of_folder.at(path).content) << path;
        EXPECT_EQ(file.type, of_folder.at(path).type) << path;
    }
}

}  // namespace
}  // namespace shaker::web
