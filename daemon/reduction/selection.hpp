#pragma once
// The part of a measurement that can be reduced, with checked errors.
#include <span>
#include <vector>

#include "calibration/harmonics/harmonic_sums.hpp"
#include "daemon/reduction/measurement.hpp"

namespace shaker::reduction {

/// Fewest pictures a period: slower cameras alias the drive, which no later step would detect.
inline constexpr double least_frames = 5;

/// The measurement cut to from_s..to_s, without views that have no positions. Each sd_m is raised to at least
/// a third of its view's median (1 um if the tracker gives none). Accelerometer samples are not cut: their
/// clock is not aligned yet. Throws InputError that names the stream: no walker, base or accelerometer, lists
/// of different lengths, non-finite values, times that do not increase, a nominal frequency outside
/// 0.01..10000 Hz, fewer than two drive periods in common.
Measurement usable_part(Measurement m);

/// First and last time covered by any of these views.
struct Span {
    double from_s;
    double to_s;
};
Span span_of(std::span<const MotionSeries> views);

/// Harmonics of one target from all views, each view with its own constant.
struct ViewsFit {
    calibration::HarmonicFit fit;
    std::vector<double> scale;  // per view: rms of the residuals in units of the tracker's standard deviation
};

/// Sums for fits of one target over all views. The views must outlive it.
calibration::HarmonicSums sums_of(std::span<const MotionSeries> views, double frequency_hz, int order,
                                  calibration::Slope slope);

/// Fits harmonics 1..order twice; the second fit weights each view by its residuals in the first.
ViewsFit fit_views(const calibration::HarmonicSums& sums, int order);

/// Frames per period of the fastest view.
double frames_per_period(std::span<const MotionSeries> views, double frequency_hz);

}  // namespace shaker::reduction
