#pragma once
// What the base did beside the shaker's axis.
#include <vector>

#include "daemon/reduction/aligner.hpp"
#include "daemon/reduction/reduction.hpp"

namespace shaker {

/// Sets MeasuredHarmonic::across; errors from the scatter across the axis.
void measure_across(const Alignment& drive, std::vector<MeasuredHarmonic>& harmonics);

}  // namespace shaker
