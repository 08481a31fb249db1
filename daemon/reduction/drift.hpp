#pragma once
// Drift: slope of the walker's motion, with an error from the scatter between periods.
#include <string>
#include <vector>

#include "daemon/reduction/drift_spread.hpp"
#include "daemon/reduction/selection.hpp"

namespace shaker::reduction {

/// A walker position minus its view's constant, the straight line and the periodic motion.
struct Residual {
    double t_s;
    double y_m;
    double sd_m;
};

struct Drift {
    calibration::Estimate v_D;        // m/s; +-2 sigma covers 95 %
    ViewsFit motion;                  // of the walker on master time
    std::vector<Residual> residuals;  // of all views, in order of time
    DriftSpread spread;
    calibration::Estimate
        residual_m;  // rms of the residuals; sigma: rms of the standard deviations given by the trackers
};

/// Fits x = c_view + v_D t + sum_{q=1..12} harmonics at the drive's frequency (fewer harmonics with few
/// frames per period).
/// sigma of v_D: drift_spread() of the period means, at least that of least squares; with fewer than 3 whole
/// periods three times the latter, with a note. Adds a note and widens sigma when D still changes during the
/// run (the walker is settling) and when views disagree.
Drift measure_drift(std::span<const MotionSeries> walkers, double frequency_hz,
                    std::vector<std::string>& notes);

/// Means over the periods from start + k/f to start + (k+1)/f, k >= 0, that have at least 90 % of the usual
/// number of frames.
std::vector<PeriodMean> period_means(std::span<const Residual> residuals, double start_s,
                                     double frequency_hz);

}  // namespace shaker::reduction
