#pragma once
// Mock GigE Vision cameras for tests, and pictures that can be told apart.
#include <cstdint>
#include <string>

#include "drivers/data.hpp"
#include "drivers/devices.hpp"

namespace shaker::test {

/// Moves the test's process into a network of its own, once, with 127.0.0.1 and 127.0.0.2: tests that run at
/// the same time do not meet. Returns what was refused.
std::string private_network();

/// A picture whose every pixel depends on `number`.
FramePtr numbered_picture(std::uint64_t number, int width, int height, int bytes_per_pixel = 1);
/// Whether two pictures have the same size and pixels.
bool same_picture(const Frame& a, const Frame& b);

/// The next frame, patiently; null after 5 s.
FramePtr next_frame(Camera& camera);

}  // namespace shaker::test
