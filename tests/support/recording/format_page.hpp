#pragma once
// The tables of daemon/recording/FORMAT.md as the code has them.
#include <string>

namespace shaker::test {

/// The page with its tables as the code has them: all that stands between the lines "<!-- tables -->" and
/// "<!-- end of tables -->" is replaced. The page unchanged where it has no such lines.
std::string with_tables(const std::string& page);

}  // namespace shaker::test
