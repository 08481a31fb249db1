#pragma once
// Drift: slope of the walker's motion, with an error from the scatter between periods.
#include <string>
#include <vector>

#include "daemon/reduction/selection.hpp"
#include "daemon/reduction/spread/drift_spread.hpp"

namespace shaker::reduction {

/// A walker position minus its view's constant, the straight line and the periodic motion.
struct Residual {
    double t_s;
    double y_m;
    double sd_m;
};

struct Drift {
    calibration::Estimate v_D;        // m/s; +-2 sigma covers 95 %
    calibration::Estimate settled;    // m/s, v_D after the approach; NaN unless the walker is settling
    ViewsFit motion;                  // of the walker on master time
    std::vector<Residual> residuals;  // of all views, in order of time
    DriftSpread spread;
    /// Rms of the residuals; sigma: rms of the standard deviations given by the trackers.
    calibration::Estimate residual_m;
};

/// Fits x = c_view + v_D t + sum_{q=1..12} harmonics at the drive's frequency (fewer harmonics with few
/// frames per period).
/// sigma of v_D: drift_spread() of the period means; with fewer than 3 whole periods three times that of
/// least squares, with a note. Adds a note and widens sigma where the walker is settling (so that +-2 sigma
/// reach the settled value) and where views disagree; adds a note where the record is too short for the
/// memory of the drift. drive_effect_mps: largest change of v_D that the change of the drive during the
/// record explains; an approach within it is not the walker's.
Drift measure_drift(std::span<const MotionSeries> walkers, double frequency_hz, double drive_effect_mps,
                    std::vector<std::string>& notes);

/// Means over the periods from start + k/f to start + (k+1)/f, k >= 0, that have at least 90 % of the usual
/// number of frames.
std::vector<PeriodMean> period_means(std::span<const Residual> residuals, double start_s,
                                     double frequency_hz);

}  // namespace shaker::reduction
