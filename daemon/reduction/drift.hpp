#pragma once
// The walker's drift: a straight line under its periodic motion, with an error that the periods themselves
// tell.
#include <string>
#include <vector>

#include "daemon/reduction/drift_spread.hpp"
#include "daemon/reduction/usable_part.hpp"

namespace shaker {

/// A walker position with its view's constant, the straight line and the periodic motion taken off.
struct Residual {
    double t_s;
    double y_m;
    double sd_m;
};

struct Drift {
    Estimate v_D;                     // m/s; +-2 sigma covers 95 %
    ViewsFit motion;                  // of the walker, on master time
    std::vector<Residual> residuals;  // of all views, in order of time
    DriftSpread spread;
    Estimate residual_m;  // rms about the fit; sigma: rms of what the trackers claimed
};

/// v_D by x = c_view + v_D t + harmonics up to 12 (fewer when there are few frames a period) at the
/// frequency. sigma: drift_spread() of the period means, not less than the plain least-squares one; with less
/// than 3 whole periods only the latter, tripled, with a note. Notes and a wider sigma when D still changes
/// in the run (the walker is settling) and when views disagree.
Drift measure_drift(std::span<const MotionSeries> walkers, double frequency_hz,
                    std::vector<std::string>& notes);

/// Means over the periods from start + k/f to start + (k+1)/f that are covered to 90 % at least; k of the
/// first is 0 or more.
std::vector<PeriodMean> period_means(std::span<const Residual> residuals, double start_s,
                                     double frequency_hz);

}  // namespace shaker
