#pragma once
// Check of times and targets: the cameras must show the motion of the base that the accelerometer measures.
#include <span>
#include <string>

#include "calibration/harmonics/harmonic_fit.hpp"
#include "daemon/reduction/check/bench_check.hpp"

namespace shaker::reduction {

/// A sentence for the first view that does not show harmonic 1 or 2 of the base's motion, with the frequency
/// where this view shows most; empty: all show it. A harmonic is asked for where the accelerometer makes its
/// amplitude at least ten standard errors of the view's tracks.
std::string unseen_motion(const calibration::HarmonicFit& acceleration, std::span<const SeenBase> views);

}  // namespace shaker::reduction
