#pragma once
// The Drive for one sampled period of the wanted acceleration.
#include <span>

#include "drivers/drive.hpp"

namespace shaker {

inline constexpr std::size_t least_period_samples = 2 * most_driven + 2;

/// The drive for a base acceleration that is sampled evenly over one period, in m/s^2, from any start.
/// Its time origin is where harmonic 1 has phase 0. The mean is ignored: no shaker can hold it. Throws
/// InputError for fewer samples than least_period_samples, for samples that are not finite, if harmonics
/// 1 and 2 are both missing, or if harmonics above most_driven hold more than 1 % of the rms.
Drive drive_of_period(std::span<const double> acceleration, double frequency);

}  // namespace shaker
