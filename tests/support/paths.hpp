#pragma once
// The folders that tests read. Only paths.cpp contains them, so the compiler cache works for a clone in any
// folder.
#include <string>

namespace shaker::test {

/// The top folder of the project, without a slash at the end.
const std::string& source_dir();
/// The folder of the built programs, without a slash at the end.
const std::string& build_dir();

}  // namespace shaker::test
