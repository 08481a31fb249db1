#pragma once
// A number that leaves carries its error.
#include <limits>

namespace shaker::calibration {

/// A value with its standard deviation, in the same SI unit. NaN where it could not be determined.
struct Estimate {
    double value = std::numeric_limits<double>::quiet_NaN();
    double sigma = std::numeric_limits<double>::quiet_NaN();
};

}  // namespace shaker::calibration
