#pragma once
// A movie as grey pictures.
#include <filesystem>
#include <vector>

#include "tests/support/tracking/test_picture.hpp"

namespace shaker::test {

/// All frames, 8 bits. Throws std::runtime_error if there are none.
std::vector<Shot> grey_movie(const std::filesystem::path& file);

}  // namespace shaker::test
