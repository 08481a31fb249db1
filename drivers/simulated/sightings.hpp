#pragma once
// What a camera that gives positions reports: true places on its picture, with noise.
#include <cstdint>
#include <span>
#include <vector>

#include "drivers/data.hpp"
#include "drivers/simulated/renderer.hpp"

namespace shaker::simulated {

/// Standard deviation of a reported position, px: that of the tracker on the paper's bench, rounded up.
inline constexpr double sighting_sd_px = 0.01;

/// Sightings of the targets of `camera`, in their order: means over `poses`, which sample the exposure. NaN
/// for the walker when it is not visible, or when its middle is outside the picture. Deterministic: the noise
/// depends only on seed, tick and target.
std::vector<Sighting> sightings(const CameraTruth& camera, const PictureLayout& layout,
                                std::span<const Pose> poses, CameraTick tick, bool walker,
                                std::uint64_t seed);

}  // namespace shaker::simulated
