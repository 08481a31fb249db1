#pragma once
// Bench check: gain of the cameras over that of the accelerometer, from the motion of the base that both see.
#include <span>
#include <string>
#include <vector>

#include "calibration/estimate.hpp"
#include "calibration/harmonics/harmonic_fit.hpp"

namespace shaker::reduction {

/// The base in one view.
struct SeenBase {
    std::string view;
    calibration::HarmonicFit position;  // m, on master time
    double exposure_s = 0;
    double scale_error = 0;  // relative standard error of the view's scale, systematic; 0: not known
};

/// One view at one harmonic q. With the base's acceleration A_q by the accelerometer, X_q its position by the
/// view, f the frequency and T the exposure:
///     ratio e^{-i q w delay} = -(q w)^2 X_q / (A_q sin(pi q f T) / (pi q f T))
struct RatioAt {
    int view = 0;  // index of the view
    int q = 0;
    calibration::Estimate ratio;
    calibration::Estimate delay_s;  // of the view behind the accelerometer on master time
};

struct ViewRatio {
    std::string view;
    calibration::Estimate ratio;  // harmonics 1 and 2
    double scale_error = 0;       // as SeenBase
};

/// Errors are standard errors by the noise of both instruments, which is taken as white; the accelerometer's
/// part is common to all views. Harmonics 1 and 2 where they exceed four standard errors in both. Delays of
/// all views have a mean of about 0 where the lag of the accelerometer's clock was fitted to the same motion.
struct GainRatio {
    std::vector<RatioAt> at;
    std::vector<ViewRatio> views;             // those with at least one harmonic
    calibration::Estimate ratio;              // all views; NaN: the base does not move enough
    calibration::Estimate second_over_first;  // ratio at 2w over that at w; free of both gains
    double systematic = NAN;  // relative standard error of `ratio` by scales and gain; NaN: no error is known
};

/// gain_error: relative standard error of the accelerometer's gain along the axis, systematic; 0: not known.
GainRatio gain_ratio(const calibration::HarmonicFit& acceleration, std::span<const SeenBase> views,
                     double gain_error);

/// Alarm: a note for each view whose ratio differs from 1, and one where the ratios at w and 2w differ, by
/// more than four standard errors. The error of a view's ratio contains the systematic errors that are known.
void note_gain(const GainRatio& check, const calibration::HarmonicFit& acceleration,
               std::span<const SeenBase> views, double gain_error, std::vector<std::string>& notes);

}  // namespace shaker::reduction
