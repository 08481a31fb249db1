#pragma once
// The accelerometer's lag from the shape of the motion that it and the cameras see.
#include <complex>
#include <string>
#include <vector>

#include "calibration/harmonics/harmonic_fit.hpp"

namespace shaker::reduction {

/// One harmonic of the base's acceleration, from the accelerometer (own clock) and from the cameras (master
/// time).
struct CommonHarmonic {
    int q;
    std::complex<double> accel, camera;
    double weight;          // 1/variance of the camera's amplitude, the larger variance
    double phase_variance;  // of both
};

/// Harmonics 1 to 3 that stand out of the noise of both.
std::vector<CommonHarmonic> common_motion(const calibration::HarmonicFit& accel,
                                          const calibration::HarmonicFit& base);

/// Facts about the clock besides the motion.
struct LagPrior {
    double uncertainty_s = 0;  // largest delay of the clock at its first sample, either sign
    bool axis_given = false;   // the sign of the shaker's axis is known
    double since_first_s = 0;  // from the clock's first sample to the middle of the record
    double rate = 0;           // master seconds per own second, minus 1
    double rate_sd = 0;
};

struct LagChoice {
    double late_s = 0;     // delay in the middle of the record
    double first_s = 0;    // delay at the clock's first sample, by the rate
    bool flipped = false;  // sign of the axis reversed
    double spread_s = 0;   // rms difference of all possible delays from late_s; 0 when it is the only one
};

/// The shift with the most similar shape; of equal ones, which may differ by parts of a period, and of whole
/// periods the one whose delay at the clock's first sample is smallest. All whose delay is within the
/// uncertainty (and 3 sigma of the rate) are possible. `offset_s`: origin of the accelerometer's harmonics
/// on its own clock minus that of the cameras' on master time. Adds a note for each ambiguity.
LagChoice choose_lag(const std::vector<CommonHarmonic>& common, double frequency_hz, double offset_s,
                     const LagPrior& prior, std::vector<std::string>& notes);

}  // namespace shaker::reduction
