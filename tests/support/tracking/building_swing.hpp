#pragma once
// Real footage: seven dots on each beam of a model building, 20 frames per second, up to 100 px between
// frames.
#include <filesystem>
#include <vector>

#include "drivers/view.hpp"
#include "tests/support/tracking/test_picture.hpp"
#include "tracking/tracker.hpp"

namespace shaker::test {

/// The dots of a beam ("top", "bottom") as targets.
View beam_view(const std::string& beam);

/// One row for each frame, one column for each target.
std::vector<std::vector<tracking::Fix>> follow(const View& view, const std::vector<Shot>& movie);

}  // namespace shaker::test
