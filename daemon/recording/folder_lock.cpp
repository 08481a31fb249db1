#include "daemon/recording/folder_lock.hpp"

#include <spdlog/fmt/fmt.h>

#include <utility>

#include "drivers/errors.hpp"

namespace shaker::recording {

h5::FileLock lock_folder(const std::filesystem::path& folder) {
    const std::filesystem::path file = folder / folder_lock_name;
    if (auto lock = h5::FileLock::take(file, true)) return std::move(*lock);
    throw InputError{
        fmt::format("recordings {}: process {} records into this folder; end it, or choose another folder",
                    folder.string(), h5::locked_by(file).value_or(0))};
}

}  // namespace shaker::recording
