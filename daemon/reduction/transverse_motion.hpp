#pragma once
// Motion of the base across the shaker's axis.
#include <vector>

#include "daemon/reduction/aligner.hpp"
#include "daemon/reduction/reduction.hpp"

namespace shaker::reduction {

/// Sets MeasuredHarmonic::across, with errors from the scatter across the axis.
void measure_across(const Alignment& drive, std::vector<MeasuredHarmonic>& harmonics);

}  // namespace shaker::reduction
