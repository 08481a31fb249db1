#include "daemon/recording/disk_space.hpp"

#include <spdlog/fmt/fmt.h>

#include "drivers/errors.hpp"

namespace shaker::recording {

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
