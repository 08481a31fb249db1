#include "tests/support/shared_data.hpp"

#include <cstdlib>
#include <stdexcept>

#include "tests/support/paths.hpp"

namespace shaker {

std::filesystem::path shared_data(std::string_view name) {
    auto folder = std::filesystem::path{test::source_dir()} / ".." / "shared" / "data" / name;
    if (std::filesystem::is_directory(folder)) return folder;
    if (std::getenv("CI") != nullptr) throw std::runtime_error{"no shared data at " + folder.string()};
    return {};
}

std::string missing_data(std::string_view name) {
    return "needs the data set \"" + std::string{name} + "\" in ../shared/data, which a clone does not have";
}

}  // namespace shaker
