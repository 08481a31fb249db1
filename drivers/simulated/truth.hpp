#pragma once
// Where things really were on the simulated bench.
#include <vector>

#include "drivers/time.hpp"

namespace shaker {

/// Where base and walker really were in the middle of one exposure, m on the shaker's axis.
struct PoseTruth {
    CameraTick tick;
    MasterTime time;
    double base = 0;
    double walker = 0;
};

/// The walker's mean velocity between two times (s) within the exposures, m/s; NaN where one is not. A
/// straight line between exposures h apart is off by at most mu g h^2 / 8: 0.14 um for 1 ms.
double drift_velocity(const std::vector<PoseTruth>& poses, double from_s, double to_s);

}  // namespace shaker
