#pragma once
// Error of a drift when both positions and drift scatter between periods.
#include <span>
#include <vector>

namespace shaker::reduction {

/// Mean position over one period, without the periodic motion (and any straight line).
struct PeriodMean {
    int k = 0;       // index of the period; increasing, gaps allowed
    double y_m = 0;  // mean
    int frames = 0;  // number of positions
};

/// Range of the standard deviation of one period's mean, from the scatter within periods.
struct ErrorOfMean {
    double least_m;
    double most_m;
};

struct DriftSpread {
    /// Half of the 95 % half-width of the drift per period (m) from a straight line through all positions:
    /// +-2 sigma covers 95 %, also for few periods. Infinite for fewer than 3 periods.
    double sigma_m = 0;
    double jitter_m = 0;      // m, standard deviation of D between periods, most likely value
    double mean_error_m = 0;  // m, standard deviation of one period's mean without jitter, most likely value
    /// Change of D over the run, m, by a straight line; trend_t = value / standard error with `freedom`
    /// degrees.
    double trend_m = 0;
    double trend_t = 0;
    int freedom = 0;
};

/// Model: y_k = sum of D_j up to the middle of period k + e_k; D_j = D + jitter, e_k independent. Differences
/// of successive means have variance jitter^2/2 + 2 error^2 and covariance jitter^2/4 - error^2 with the
/// next. `scatter`: range of the error from the scatter within periods. Both unknowns are averaged over with
/// restricted likelihood as weight, so that neither noise nor jitter makes sigma too small. Where jitter
/// cannot be separated from white noise, sigma is up to 3 times the line's own scatter. O(periods).
DriftSpread drift_spread(std::span<const PeriodMean> means, const ErrorOfMean& scatter);

/// Half of the 95 % quantile of |t| with n degrees of freedom: the factor that widens a standard error.
double few_periods_factor(int freedom);

}  // namespace shaker::reduction
