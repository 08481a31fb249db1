#include "tests/support/shared_data.hpp"

#include <cstdlib>
#include <stdexcept>

namespace shaker {

std::filesystem::path shared_data(std::string_view name) {
    auto folder = std::filesystem::path{SHAKER_SOURCE_DIR} / ".." / "shared" / "data" / name;
    if (std::filesystem::is_directory(folder)) return folder;
    if (std::getenv("CI") != nullptr) throw std::runtime_error{"no shared data at " + folder.string()};
    return {};
}

}  // namespace shaker
