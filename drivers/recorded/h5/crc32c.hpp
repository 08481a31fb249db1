#pragma once
// Checksum of recordings: CRC-32C (Castagnoli), as in iSCSI and ext4. Detects every burst error of up to 32
// bits.
#include <cstddef>
#include <cstdint>
#include <span>

namespace shaker::h5 {

/// The checksum of `bytes`, continued from `before`, that of the preceding bytes (0: no preceding bytes).
[[nodiscard]] std::uint32_t crc32c(std::span<const std::byte> bytes, std::uint32_t before = 0) noexcept;

}  // namespace shaker::h5
