#include "tests/support/program.hpp"

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <fstream>
#include <sstream>

namespace shaker::test {

namespace {
std::string content(const std::filesystem::path& file) {
    std::ifstream in{file, std::ios::binary};
    std::ostringstream text;
    text << in.rdbuf();
    return text.str();
}
}  // namespace

Outcome shakerd(const std::string& arguments, const std::filesystem::path& folder, int limit_s) {
    const auto out = folder / ".out", err = folder / ".err";
    const std::string command = "cd '" + folder.string() + "' && timeout -k 5 " + std::to_string(limit_s) +
                                " '" SHAKER_BINARY_DIR "/shakerd' " + arguments + " >'" + out.string() +
                                "' 2>'" + err.string() + "' </dev/null";
    const int status = std::system(command.c_str());
    Outcome o{WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), content(out), content(err)};
    std::filesystem::remove(out);
    std::filesystem::remove(err);
    return o;
}

std::filesystem::path fresh_folder() {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    auto folder = std::filesystem::path{testing::TempDir()} /
                  (std::string{"shakerd-"} + info->test_suite_name() + "-" + info->name());
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder);
    return folder;
}

}  // namespace shaker::test
