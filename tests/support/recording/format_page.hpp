#pragma once
// Tables of pages for users that are generated from the code: daemon/recording/FORMAT.md,
// daemon/campaign/POINTS.md.
#include <functional>
#include <string>
#include <vector>

#include "drivers/recorded/recording_file.hpp"

namespace shaker::test {

/// The page with the tables of a recording between the lines "<!-- tables -->" and "<!-- end of tables -->".
/// Without these lines the page is unchanged.
std::string with_tables(const std::string& page);
/// The same with the tables of these groups.
std::string with_tables(const std::string& page, const std::vector<recorded::GroupLayout>& groups);

/// A failure of the test when a page of the project differs from with(page); then the correct page is in the
/// folder of the build.
void expect_page(const std::string& page, const std::function<std::string(const std::string&)>& with);

}  // namespace shaker::test
