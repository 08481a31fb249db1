#pragma once
// The points of a plan in the order of their measurement.
#include <vector>

#include "daemon/campaign/plan.hpp"

namespace shaker::campaign {

inline constexpr std::size_t most_points = 100'000;

/// The drive whose drift is the opposite for any friction that is the same in both directions, on a level
/// base: half a period later it is the mirror image. phi differs by pi, the harmonics 4, 6 and 8 by their
/// sign.
Drive mirror_partner(const Drive& drive);

/// Series after series, each as its order says, `repeats` times; an up_down series goes up and down in each
/// repeat. Equal plans give equal points on any machine: order random is Fisher and Yates' shuffle from the
/// last point to the second, with x mod i of successive numbers x of std::mt19937_64 {seed}. InputError for
/// more than most_points.
std::vector<Point> schedule(const Plan& plan);

}  // namespace shaker::campaign
