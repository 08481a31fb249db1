#include "tests/support/paths.hpp"

namespace shaker::test {

const std::string& source_dir() {
    static const std::string folder = SHAKER_SOURCE_DIR;
    return folder;
}

const std::string& build_dir() {
    static const std::string folder = SHAKER_BINARY_DIR;
    return folder;
}

}  // namespace shaker::test
