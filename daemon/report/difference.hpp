#pragma once
// A measured value beside the one that was expected.
#include <string>

#include "calibration/estimate.hpp"

namespace shaker::report {

/// "+3.012 um/s = +0.020 %": measured minus expected, both given in m/s. The share is left out where the
/// expected value is not larger than the measured one's error, 0 for example: it would say nothing.
std::string speed_difference(const calibration::Estimate& measured, double expected, int digits);

}  // namespace shaker::report
