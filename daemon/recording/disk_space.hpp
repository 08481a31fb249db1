#pragma once
// Space on the disk of a recording.
#include <cstdint>
#include <filesystem>
#include <string>

namespace shaker::recording {

/// "1.07 GB".
std::string gigabytes(std::uint64_t bytes);
/// DeviceError when the disk does not answer.
std::uint64_t free_bytes(const std::filesystem::path& file);
/// InputError unless `taken` bytes fit besides those that must stay free. taken: of the first pictures.
void require_space(const std::filesystem::path& file, std::uint64_t stays, std::uint64_t taken);

}  // namespace shaker::recording
