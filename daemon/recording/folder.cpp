#include "daemon/recording/folder.hpp"

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

std::string gigabytes(std::uint64_t bytes) {
    return fmt::format("{:.2f} GB", 1e-9 * static_cast<double>(bytes));
}

std::uint64_t free_bytes(const std::filesystem::path& file) {
    std::error_code failed;
    const std::filesystem::space_info space =
        std::filesystem::space(file.has_parent_path() ? file.parent_path() : ".", failed);
    if (failed) throw DeviceError{file.string() + ": " + failed.message()};
    return space.available;
}

void require_space(const std::filesystem::path& file, std::uint64_t stays, std::uint64_t taken) {
    const std::uint64_t room = free_bytes(file);
    if (room >= stays && room - stays >= taken) return;
    const std::string more =
        taken > 0 ? fmt::format(", and the first pictures take {}; keep no pictures, or make space",
                                gigabytes(taken))
                  : std::string{"; make space"};
    throw InputError{fmt::format("{}: the disk has {} free; {} must stay free{}", file.string(),
                                 gigabytes(room), gigabytes(stays), more)};
}

}  // namespace shaker::recording
