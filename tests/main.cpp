// The main of every test program. `--gtest_filter=file:daemon/run/run_test` selects the tests of that file
// below tests, so that ctest has one entry a file.
#include <gtest/gtest.h>

#include <iostream>
#include <string>
#include <string_view>

namespace {

/// gtest's filter for the tests of `file`; empty when it has none.
std::string tests_in(std::string_view file) {
    const std::string end = "tests/" + std::string{file} + ".cpp";
    const testing::UnitTest& all = *testing::UnitTest::GetInstance();
    std::string filter;
    for (int s = 0; s < all.total_test_suite_count(); ++s) {
        const testing::TestSuite& suite = *all.GetTestSuite(s);
        for (int t = 0; t < suite.total_test_count(); ++t) {
            const testing::TestInfo& test = *suite.GetTestInfo(t);
            if (!std::string_view{test.file()}.ends_with(end)) continue;
            if (!filter.empty()) filter += ':';
            filter.append(suite.name()).append(".").append(test.name());
        }
    }
    return filter;
}

}  // namespace

int main(int argc, char** argv) {
    testing::InitGoogleTest(&argc, argv);
    constexpr std::string_view of_file = "file:";
    const std::string asked = testing::GTEST_FLAG(filter);
    if (asked.starts_with(of_file)) {
        const std::string filter = tests_in(std::string_view{asked}.substr(of_file.size()));
        if (filter.empty()) {
            std::cerr << asked << ": this program has no test of that file\n";
            return 1;
        }
        testing::GTEST_FLAG(filter) = filter;
    }
    return RUN_ALL_TESTS();
}
