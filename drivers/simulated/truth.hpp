#pragma once
// True positions on the simulated bench.
#include <vector>

#include "drivers/time.hpp"

namespace shaker::simulated {

/// True positions of base and walker in the middle of one exposure, m on the shaker's axis.
struct PoseTruth {
    CameraTick tick;
    MasterTime time;
    double base = 0;
    double walker = 0;
};

/// Mean velocity of the walker between two times (s) within the exposures, m/s; NaN if a time is outside.
/// Linear interpolation between exposures h apart has an error of at most mu g h^2 / 8: 0.14 um for 1 ms.
double drift_velocity(const std::vector<PoseTruth>& poses, double from_s, double to_s);

}  // namespace shaker::simulated
