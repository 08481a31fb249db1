#pragma once
// Mock GigE Vision cameras for tests, and distinguishable pictures.
#include <cstdint>
#include <string>

#include "drivers/data.hpp"
#include "drivers/devices.hpp"

namespace shaker::test {

/// Moves the process of the test into a private network with 127.0.0.1 and 127.0.0.2, once, so that
/// concurrent tests do not interfere. Returns the error message if it was refused.
std::string private_network();

/// A picture in which every pixel depends on `number`.
FramePtr numbered_picture(std::uint64_t number, int width, int height, int bytes_per_pixel = 1);
/// Whether two pictures have the same size and pixels.
bool same_picture(const Frame& a, const Frame& b);

/// The next frame; null after 5 s.
FramePtr next_frame(Camera& camera);

}  // namespace shaker::test
