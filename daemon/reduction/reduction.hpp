#pragma once
// Reduction: positions and accelerations to v_D, D, measured drive, efficiency, stick intervals.
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "calibration/accelerometer/response_fit.hpp"
#include "calibration/accelerometer/transverse.hpp"
#include "calibration/estimate.hpp"
#include "daemon/reduction/check/bench_check.hpp"
#include "daemon/reduction/measurement.hpp"

namespace shaker::reduction {

/// One harmonic of the base's acceleration, with the time origin where harmonic 1 has phase 0.
struct MeasuredHarmonic {
    int q = 0;
    calibration::Estimate amplitude;   // m/s^2
    calibration::Estimate phase;       // rad, against sin(q w t)
    calibration::Transverse across{};  // motion across the shaker's axis
};

/// One drive period: from a start (harmonic 1 of a_B crosses zero upwards) to the next.
struct PeriodResult {
    int k = 0;       // index from the first whole period in the data
    double t_s = 0;  // master time of its start
    int frames = 0;  // number of walker positions
    /// D in m: mean position of this period minus that of the previous one; NaN in the first.
    calibration::Estimate drift;
    calibration::Estimate gamma;  // m/s^2, from the accelerometer samples of this period alone
    calibration::Estimate phi;    // rad
};

/// Motion of walker and base over one period, averaged over all periods.
struct Cycle {
    std::vector<double> phase;            // t/T, 0..1
    std::vector<double> x_m, x_sd_m;      // walker, relative to its position at phase 0
    std::vector<double> v_mps, v_sd_mps;  // walker, not smoothed across the ends of slips (kinked_motion.hpp)
    std::vector<double> v_base_mps;       // base
};

/// Walker at rest on the base, in periods; `to` may exceed 1 when the interval wraps.
struct StickInterval {
    double from = 0;
    double to = 0;
    double sd = 0;  // of either end
};

/// End of a slip at which the next slip, in the other direction, begins.
struct Flip {
    double at = 0, at_sd = 0;  // middle of the change of acceleration, in periods
    /// From 10 to 90 % of the change, as of a straight change; s. Its posterior mean and standard deviation.
    calibration::Estimate duration;
    double below_s = 0;  // 19 of 20 probable durations are shorter
};

/// Systematic standard errors by calibration; sigma of the values is statistical. NaN: not known.
struct Systematic {
    double v_D = NAN, D = NAN;        // m/s, m: by the scales of the walker's views
    double gamma = NAN, v_rms = NAN;  // m/s^2, m/s: by the accelerometer's gain
    double efficiency = NAN;          // by both
    double phi = NAN;                 // rad: by the told corner of the accelerometer
};

struct Reduction {
    calibration::Estimate v_D;              // m/s; sigma is widened for few periods: +-2 sigma covers 95 %
    calibration::Estimate v_D_settled;      // m/s, of a walker that was still settling; else NaN
    calibration::Estimate D;                // m per period
    calibration::Estimate frequency;        // Hz on master time
    calibration::Estimate gamma, rho, phi;  // measured: A1 + A2 (m/s^2), A1/(A1+A2), alpha2 - 2 alpha1 (rad)
    calibration::Estimate v_rms;            // base, m/s
    calibration::Estimate efficiency;       // |v_D| / V_RMS
    Systematic systematic;
    GainRatio gain_ratio;  // cameras over accelerometer
    Corner corner;         // of the accelerometer, by cameras and setting
    Tilt tilt;
    std::vector<MeasuredHarmonic> harmonics;
    calibration::Estimate accelerometer_late_s;  // master time = t (1 + 1e-6 ppm) - late
    calibration::Estimate accelerometer_ppm;
    calibration::Estimate delay_s;           // t minus master time in the middle of the record
    std::array<double, 3> shaker_axis{};     // unit vector in sensor axes
    calibration::Estimate fit_residual_x_m;  // rms of the residuals of the walker's positions; sigma: rms of
                                             // the trackers' standard deviations
    double t0_s = 0;                         // master time of the first start of a period
    int frames = 0;                          // walker positions used, all views
    int frames_lost = 0;
    int frames_doubtful = 0;  // in which the walker's place was in doubt
    std::vector<StickInterval> stick;
    /// In units of the period, 0..1; of those that were not found (stick.hpp).
    double shortest_visible_stick = NAN;
    std::vector<Flip> flips;
    std::vector<PeriodResult> periods;
    Cycle cycle;
    int samples = 0;                 // accelerometer samples in the time of the cameras
    int samples_bad = 0;             // those that were excluded (bad_samples.hpp)
    bool degraded = false;           // too many of them, or at one phase, or a view does not show the base's
                                     // motion (unseen_motion.hpp): do not rely on the result
    std::vector<std::string> notes;  // for the operator, one sentence each
};

/// The notes that question a result: alarms of the bench check, why it is degraded, and a phi that is not
/// corrected.
std::vector<std::string> doubts_of(const Reduction& r);
/// Sets `degraded` and the alarm of the bench check as the notes have it, which are all that a recording
/// keeps.
void set_doubts(Reduction& r);

/// The base by the accelerometer against the base by the cameras at each harmonic that both show, not
/// corrected for the response of the settings. InputError as from reduce().
std::vector<calibration::ResponseLine> response_lines(Measurement measurement);

/// Reduces a run. Throws InputError when the data are insufficient: fewer than two periods in common, no
/// walker, no base. Deterministic. Move the measurement in to avoid a copy: an hour takes 0.8 GB.
Reduction reduce(Measurement measurement);

}  // namespace shaker::reduction
