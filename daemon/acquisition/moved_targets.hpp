#pragma once
// New regions of targets, by the names of camera and target.
#include <array>
#include <span>
#include <string>
#include <vector>

#include "drivers/view.hpp"

namespace shaker::acquisition {

struct MovedTarget {
    std::string camera, target;
    std::array<double, 4> roi_px{};  // x, y, width, height in the camera's picture, as a client gave them
};

/// What to do while a target is not found at the start.
inline constexpr const char* way_to_targets =
    "move its region onto it (page: \"Move targets\"; \"shakerctl targets\"), or put it into its region";

/// 'camera "top", target "walker", roi_px = [40, 20, 180, 170]'.
std::string text(const MovedTarget& moved);

/// The views with these regions. InputError that names camera and target for an unknown name, two regions of
/// one target, and numbers that the settings do not allow either.
std::vector<View> with_regions(std::vector<View> views, std::span<const MovedTarget> moved);

}  // namespace shaker::acquisition
