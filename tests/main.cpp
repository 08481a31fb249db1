// The main of every test program. `--gtest_filter=file:daemon/run/run_test-RunTest.A:RunTest.B` selects the
// tests of that file below tests but for two, so that ctest has one entry a file.
#include <fnmatch.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <iostream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace {

/// Names of the tests of `file`.
std::vector<std::string> tests_in(std::string_view file) {
    const std::string end = "tests/" + std::string{file} + ".cpp";
    const testing::UnitTest& all = *testing::UnitTest::GetInstance();
    std::vector<std::string> names;
    for (int s = 0; s < all.total_test_suite_count(); ++s) {
        const testing::TestSuite& suite = *all.GetTestSuite(s);
        for (int t = 0; t < suite.total_test_count(); ++t) {
            const testing::TestInfo& test = *suite.GetTestInfo(t);
            if (!std::string_view{test.file()}.ends_with(end)) continue;
            names.push_back(std::string{suite.name()} + '.' + test.name());
        }
    }
    return names;
}

/// gtest's filter for `file:FILE-PATTERN:...`. Throws when the file has no test, or none that a pattern
/// leaves out.
std::string filter_of(const std::string& asked) {
    const std::size_t end = std::min(asked.find('-'), asked.size());
    const std::vector<std::string> names = tests_in(std::string_view{asked}.substr(0, end));
    if (names.empty()) throw std::invalid_argument{"this program has no test of " + asked.substr(0, end)};
    std::istringstream patterns{asked.substr(std::min(end + 1, asked.size()))};
    for (std::string pattern; std::getline(patterns, pattern, ':');)
        if (std::ranges::none_of(names, [&](const std::string& name) {
                return ::fnmatch(pattern.c_str(), name.c_str(), 0) == 0;
            }))
            throw std::invalid_argument{"tests/nightly leaves out " + pattern + ", which " +
                                        asked.substr(0, end) + " does not have"};
    std::string filter;
    for (const std::string& name : names) filter += name + ':';
    filter.pop_back();
    return filter + asked.substr(end);
}

}  // namespace

int main(int argc, char** argv) {
    testing::InitGoogleTest(&argc, argv);
    constexpr std::string_view of_file = "file:";
    const std::string asked = testing::GTEST_FLAG(filter);
    if (asked.starts_with(of_file)) try {
            testing::GTEST_FLAG(filter) = filter_of(asked.substr(of_file.size()));
        } catch (const std::invalid_argument& e) {
            std::cerr << e.what() << '\n';
            return 1;
        }
    return RUN_ALL_TESTS();
}
