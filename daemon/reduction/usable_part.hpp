#pragma once
// The part of a measurement that can be reduced, with its errors told.
#include <span>
#include <vector>

#include "calibration/harmonic_sums.hpp"
#include "daemon/reduction/measurement.hpp"

namespace shaker {

/// The measurement cut to from_s..to_s, views without positions left out, each sd_m raised to a third of its
/// view's median at least (a tracker's sd may be too good to be true; 1 um where it claims none).
/// Accelerometer samples stay whole: their clock is not known yet. Throws InputError naming the stream: no
/// walker, no base or no accelerometer, lists of different lengths, values that are not finite, times that do
/// not increase, a nominal frequency out of 0.01..10000 Hz, less than two drive periods in common.
Measurement usable_part(Measurement m);

/// First and last time that all of these cover between them.
struct Span {
    double from_s;
    double to_s;
};
Span span_of(std::span<const MotionSeries> views);

/// Harmonics of one target seen by all views, each with its own constant.
struct ViewsFit {
    HarmonicFit fit;
    std::vector<double> scale;  // a view: residual rms in units of what its tracker claimed
};

/// What fits of one target need, gathered from all views, which outlive it.
HarmonicSums sums_of(std::span<const MotionSeries> views, double frequency_hz, int order, Slope slope);

/// Fits harmonics 1..order twice: the second time each view's weights come from its own residuals.
ViewsFit fit_views(const HarmonicSums& sums, int order);

/// Frames of the fastest view in one period.
double frames_per_period(std::span<const MotionSeries> views, double frequency_hz);

}  // namespace shaker
