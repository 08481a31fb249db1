#pragma once
// Phases of the base's motion by accelerometer and cameras: the accelerometer's lower corner, and a check.
#include <array>
#include <vector>

#include "calibration/accelerometer/response_fit.hpp"
#include "calibration/harmonics/harmonic_fit.hpp"
#include "daemon/reduction/check/bench_check.hpp"
#include "drivers/response/sensor_response.hpp"

namespace shaker::reduction {

/// Harmonics that stand out in both. exposure_s: of the cameras.
std::vector<calibration::ResponseLine> lines_of(const calibration::HarmonicFit& sensor,
                                                const calibration::HarmonicFit& cameras, double exposure_s);

struct TakenOff {
    Corner corner{};
    double later_s = 0,
           variance_s2 = 0;  // the accelerometer's samples are later; added variance of their time
};

/// Takes the response off the harmonics of the accelerometer along and across the shaker's axis: the low-pass
/// as stated; the corner, stated with an error, weighed with what the cameras show; where both disagree by
/// four standard errors, the cameras decide. One pole, two or Butterworth, where that was not passed, by the
/// ratio of the amplitudes. Errors of the harmonics contain those of the corner by noise and by its kind.
/// exposure_s, base: of the cameras.
TakenOff take_off(const SensorResponse& stated, double exposure_s, const calibration::HarmonicFit& base,
                  calibration::HarmonicFit& along, std::array<calibration::HarmonicFit, 2>& across);

}  // namespace shaker::reduction
