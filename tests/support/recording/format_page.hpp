#pragma once
// The tables of daemon/recording/FORMAT.md, generated from the code.
#include <string>

namespace shaker::test {

/// The page with generated tables between the lines "<!-- tables -->" and "<!-- end of tables -->". Without
/// these lines the page is unchanged.
std::string with_tables(const std::string& page);

}  // namespace shaker::test
