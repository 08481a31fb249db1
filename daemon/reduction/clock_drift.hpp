#pragma once
// Clock drift: deviation of the accelerometer's clock from a straight line, by the motion in windows.
#include <span>
#include <vector>

#include "calibration/estimate.hpp"
#include "calibration/harmonics/harmonic_fit.hpp"
#include "daemon/reduction/measurement.hpp"

namespace shaker::reduction {

/// Delay of a device's clock behind the motion of the whole record, in one window of time.
struct WindowDelay {
    double t_s = 0;                 // middle of the window, master time
    calibration::Estimate delay_s;  // error from white noise
};

/// Delays of both in the same windows.
struct WindowDelays {
    std::vector<WindowDelay> sensor, cameras;
    /// Delays of the accelerometer behind the cameras: the motion's own changes of phase cancel.
    [[nodiscard]] std::vector<WindowDelay> differences() const;
};

/// Delays in up to `most` windows of at least 4 periods. `base` and `acceleration`: the motion of the whole
/// record, position (m) and acceleration along the axis (m/s^2). A window's delay is the least-squares
/// shift of the model: y(t) = c + model(t - delay), linear in the delay, which must be well below
/// 1 rad / (q w). Windows with less than half of the usual samples are left out.
WindowDelays delays_in_windows(std::span<const MotionSeries> bases, const calibration::HarmonicFit& base,
                               std::span<const double> t_s, std::span<const double> along_mps2,
                               const calibration::HarmonicFit& acceleration, int most);

/// Delay over time: line plus random walk,
///
///     delay(t) = a + b (t - middle) + w(t),   <(w(t) - w(s))^2> = q^2 |t - s|
///
/// Between the middles of windows it is linear; beyond them it continues with slope b.
struct ClockDrift {
    std::vector<double> t_s, delay_s;  // at the middles of the windows
    calibration::Estimate middle_s;    // delay in the middle of the record
    calibration::Estimate rate;        // b: change of the delay in s each s; its error contains the walk
    double walk_s_rts = 0;             // q, s per square root of s
    double scatter = 1;                // of the windows about it, in units of their errors; at least 1
    double likelihood_ratio = 0;       // 2 ln of the likelihood over that of the best line
    /// The walk is significant: chance gives it in one of 250 records without one.
    [[nodiscard]] bool significant() const noexcept { return likelihood_ratio > 7; }
    /// The windows scatter more than their errors explain: beyond 4 standard deviations of chi^2.
    [[nodiscard]] bool scatters() const noexcept;
    [[nodiscard]] double at(double t_s) const noexcept;
    /// Largest distance from the line through the middle with slope b, s.
    [[nodiscard]] double farthest_from_line(double middle_s) const noexcept;
};

/// White scatter of the windows: as large as their errors say, or larger.
enum class WindowScatter { as_stated, free };

/// The most likely drift, by the restricted likelihood of q and of the white scatter. Fewer than 6 windows:
/// none, with an empty list.
ClockDrift drift_of(const std::vector<WindowDelay>& windows, double middle_s,
                    WindowScatter scatter = WindowScatter::free);

/// Walk of the accelerometer's clock that its own delays show but the cameras cannot confirm, s per square
/// root of s. It is 0 where the cameras show the same delays: then the motion's phase changes, not the clock.
double unconfirmed_walk(const WindowDelays& delays);

}  // namespace shaker::reduction
