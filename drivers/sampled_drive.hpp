#pragma once
// A drive from one period of the acceleration that is wanted.
#include <span>

#include "drivers/drive.hpp"

namespace shaker {

inline constexpr std::size_t least_period_samples = 2 * most_driven + 2;

/// The drive whose base acceleration is this: evenly sampled over one period, m/s^2, from any point of it;
/// time begins where harmonic 1 has phase 0. The mean is left out: no shaker holds it. InputError for fewer
/// samples than least_period_samples, for numbers that are not finite, where harmonics 1 and 2 are both
/// missing, and where harmonics beyond most_driven hold more than 1 % of it (rms): it would be another shape.
Drive drive_of_period(std::span<const double> acceleration, double frequency);

}  // namespace shaker
