#pragma once
// What the base did beside the shaker's axis.
#include <vector>

#include "daemon/reduction/aligner.hpp"
#include "daemon/reduction/reduction.hpp"

namespace shaker {

/// Fits the samples of an alignment across its axis like those along it, and sets MeasuredHarmonic::across;
/// errors from the scatter across the axis.
void measure_across(const Alignment& drive, const AccelSeries& samples,
                    std::vector<MeasuredHarmonic>& harmonics);

}  // namespace shaker
