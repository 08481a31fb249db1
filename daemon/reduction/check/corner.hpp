#pragma once
// Phases of the base's motion by accelerometer and cameras: the accelerometer's lower corner, and a check.
#include <array>

#include "calibration/harmonics/harmonic_fit.hpp"
#include "daemon/reduction/check/bench_check.hpp"
#include "drivers/response/lower_corner.hpp"

namespace shaker::reduction {

struct TakenOff {
    Corner corner{};
    double later_s = 0,
           variance_s2 = 0;  // the accelerometer's samples are later; added variance of their time
};

/// Takes the corner off the harmonics of the accelerometer along and across the shaker's axis. Told with an
/// error, it is weighed with what the cameras show; where both disagree by four standard errors, the cameras
/// decide. One pole or two, where that was not passed, by the ratio of the amplitudes. Errors of the
/// harmonics contain those of the corner by noise and by the number of its poles. exposure_s, base: of the
/// cameras.
TakenOff take_off(const LowerCorner& told, double exposure_s, const calibration::HarmonicFit& base,
                  calibration::HarmonicFit& along, std::array<calibration::HarmonicFit, 2>& across);

}  // namespace shaker::reduction
