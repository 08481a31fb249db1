#include "daemon/commands/serve_settings.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "drivers/errors.hpp"
#include "tests/support/program.hpp"

namespace shaker::commands {
namespace {

std::filesystem::path page_with(const std::string& serve) {
    const auto file = test::fresh_folder() / "shakerd.toml";
    std::ofstream{file} << "[serve]\nrecordings = \".\"\n" << serve;
    ServeOptions options;
    options.settings = file;
    return serve_settings(options).server.page;
}

TEST(ServeSettingsTest, PageIsTheProgramsOwnOrAFolder) {
    EXPECT_EQ(page_with(""), "");
    EXPECT_EQ(page_with("page = \"/usr\"\n"), "/usr");
    const std::filesystem::path old{"/usr/share/shakerd/panel"};  // in settings of older packages
    EXPECT_EQ(page_with("page = \"" + old.string() + "\"\n"), std::filesystem::exists(old) ? old : "");
}

TEST(ServeSettingsTest, PageNeedsItsFolder) {
    try {
        page_with("page = \"/no/such\"\n");
        FAIL();
    } catch (const InputError& e) {
        EXPECT_NE(std::string{e.what()}.find("shakerd.toml:3: serve.page: \"/no/such\": there is no such folder"),
                  std::string::npos)
            << e.what();
    }
}

}  // namespace
}  // namespace shaker::commands
