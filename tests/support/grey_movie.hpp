#pragma once
// A movie as grey pictures, whatever it was stored as.
#include <filesystem>
#include <vector>

#include "tests/support/test_picture.hpp"

namespace shaker::test {

/// All frames, 8 bit. Throws std::runtime_error when there are none.
std::vector<Shot> grey_movie(const std::filesystem::path& file);

}  // namespace shaker::test
