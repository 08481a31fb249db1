#pragma once
// The checksum of recordings: CRC-32C (Castagnoli), as in iSCSI and ext4. Detects every burst of up to 32
// bits.
#include <cstddef>
#include <cstdint>
#include <span>

namespace shaker {

/// Of `bytes`, going on from that of what came before them (0: nothing did).
[[nodiscard]] std::uint32_t crc32c(std::span<const std::byte> bytes, std::uint32_t before = 0) noexcept;

}  // namespace shaker
