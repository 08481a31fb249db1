#pragma once
// Alignment: maps the accelerometer to the cameras' time by the motion that both see; finds frequency and
// shaker axis.
#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "calibration/harmonics/harmonic_fit.hpp"
#include "daemon/reduction/check/bench_check.hpp"
#include "daemon/reduction/measurement.hpp"

namespace shaker::reduction {

/// Words of a note on a frame rate that is, or may be, off.
inline constexpr std::string_view frame_rate_note = "the errors of v_D and frequency contain";

/// The measured drive on master time. master = t (1 + 1e-6 ppm) - late, t on the accelerometer's clock.
struct Alignment {
    calibration::Estimate frequency;  // Hz on master time
    calibration::HarmonicFit base;    // of the base's position, m
    /// Of the base along the shaker's axis, m/s^2, sign as AccelerometerInfo::acceleration; the constant is
    /// gravity and offset. Its errors do not take what repeats with the drive for noise.
    calibration::HarmonicFit acceleration;
    std::array<double, 3> shaker_axis{};
    std::array<calibration::HarmonicFit, 2> across;  // of the base on the shaker axis' across_axes(), m/s^2
    calibration::Estimate late_s, ppm;               // of the straight line nearest to the clock
    calibration::Estimate delay_s;                   // t minus master time in the middle of the record
    /// Share by which the cameras' frame rate in the settings is too high, as accelerometer and nominal
    /// frequency agree; its error. Both 0 where the clocks differ no more than crystals do.
    double frame_rate_off = 0, frame_rate_error = 0;
    std::size_t first_sample = 0;    // index of the first accelerometer sample that the cameras cover
    std::vector<double> t_s;         // master time of the accelerometer samples that the cameras cover
    std::vector<double> along_mps2;  // those samples along the shaker's axis
};

/// `m` as usable_part() returns it.
/// Frequency: exact, or from the base's tracks (the nominal one may be 1 % off) and, in short runs, also from
/// the accelerometer, whose clock is assumed within 300 ppm (one sigma).
/// Lag: weighted fit of the phases of harmonics 1 to 3 above the noise. Whole periods: the smallest lag at
/// the clock's first sample, by the rate. Sign of the axis: from the shape of the motion or, for a single
/// harmonic or odd harmonics only, from the smaller lag. Other possible lags are part of the lag's error.
/// Drift: a clock that deviates significantly from a straight line is followed in windows (clock_drift.hpp).
/// Adds a note for each ambiguous choice, for drift, and where clock or axis disagree with the settings.
/// Throws InputError when fewer than two periods are in common after alignment.
Alignment align(const Measurement& m, std::vector<std::string>& notes);

/// Corrects the measured drive, its samples and their times for its response (check/corner.hpp). stated: of
/// the accelerometer's settings. exposure_s: of the cameras.
Corner take_off(const SensorResponse& stated, double exposure_s, Alignment& drive);

}  // namespace shaker::reduction
