#pragma once
// Runs the built program as its user does.
#include <filesystem>
#include <string>

namespace shaker::test {

struct Outcome {
    int status = -1;  // exit status; 128 + n when a signal n ended it
    std::string out;  // standard output
    std::string err;  // standard error
};

/// shakerd with these arguments, as a shell would split them, in `folder`. With a limit (s) it is killed
/// after that time; its status is then 124 or 137.
Outcome shakerd(const std::string& arguments, const std::filesystem::path& folder, int limit_s = 0);

/// A new empty folder for the current test.
std::filesystem::path fresh_folder();

}  // namespace shaker::test
