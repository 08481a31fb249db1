#pragma once
// Encodes a picture as a GigE Vision camera sends it.
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "drivers/data.hpp"

namespace shaker::mock {

/// Appends a region (x, y, width, height; inside the picture) in a grey PFNC format: Mono8, 10, 12 or 16,
/// plain (little-endian), GigE Vision's "Packed" or PFNC's "p". Throws InputError for other formats.
void append_pixels(const Frame& frame, const std::array<int, 4>& region, std::uint32_t format,
                   std::vector<std::byte>& out);

}  // namespace shaker::mock
