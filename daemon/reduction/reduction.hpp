#pragma once
// Positions and accelerations to the law: v_D, D, the drive as measured, efficiency, stick intervals.
#include <array>
#include <string>
#include <vector>

#include "calibration/estimate.hpp"
#include "calibration/transverse.hpp"
#include "daemon/reduction/measurement.hpp"

namespace shaker {

/// One harmonic of the base acceleration, with the time origin where harmonic 1 has phase 0.
struct MeasuredHarmonic {
    int q = 0;
    Estimate amplitude;   // m/s^2
    Estimate phase;       // rad, against sin(q w t)
    Transverse across{};  // motion beside the shaker's axis
};

/// One drive period: from a start (harmonic 1 of a_B crosses zero upwards) to the next.
struct PeriodResult {
    int k = 0;       // counts from the first whole period in the data
    double t_s = 0;  // master time of its start
    int frames = 0;  // walker positions in it
    Estimate
        drift;  // D in m: mean position over this period minus that over the one before; NaN in the first
    Estimate gamma;  // m/s^2, from the accelerometer's samples of this period alone
    Estimate phi;    // rad
};

/// The walker's and the base's motion over one period, averaged over all periods.
struct Cycle {
    std::vector<double> phase;            // t/T, 0..1
    std::vector<double> x_m, x_sd_m;      // walker, from its position at phase 0
    std::vector<double> v_mps, v_sd_mps;  // walker
    std::vector<double> v_base_mps;       // base
};

/// Walker at rest on the base, in units of the period; to may exceed 1 when it wraps.
struct StickInterval {
    double from = 0;
    double to = 0;
    double sd = 0;  // of either end
};

struct Reduction {
    Estimate v_D;              // m/s; sigma widened for the few periods, so that +-2 sigma covers 95 %
    Estimate D;                // m a period
    Estimate frequency;        // Hz on master time
    Estimate gamma, rho, phi;  // as measured: A1 + A2, A1/(A1+A2), alpha2 - 2 alpha1
    Estimate v_rms;            // base, m/s
    Estimate efficiency;       // |v_D| / V_RMS
    std::vector<MeasuredHarmonic> harmonics;
    Estimate accelerometer_late_s;  // master time = t (1 + 1e-6 ppm) - late
    Estimate accelerometer_ppm;
    std::array<double, 3> shaker_axis{};  // unit vector in sensor axes
    Estimate fit_residual_x_m;  // rms of walker positions about the fit; sigma: what the tracker claimed
    double t0_s = 0;            // master time of the first start of a period
    int frames = 0;             // walker positions used, over all views
    int frames_lost = 0;
    std::vector<StickInterval> stick;
    std::vector<PeriodResult> periods;
    Cycle cycle;
    std::vector<std::string> notes;  // what the operator should know, one sentence each
};

/// Reduces a run. Throws InputError when there is not enough to reduce: streams with less than two periods in
/// common, no walker, no base. Deterministic. A measurement that is moved here is not copied: an hour of it
/// takes 0.8 GB.
Reduction reduce(Measurement measurement);

}  // namespace shaker
