#pragma once
// How well a drift is known when both the positions and the drift itself scatter from period to period.
#include <span>
#include <vector>

namespace shaker {

/// Mean position over one period, the periodic motion (and any straight line) taken off.
struct PeriodMean {
    int k = 0;       // period; gaps allowed, increasing
    double y_m = 0;  // mean
    int frames = 0;  // positions in it
};

/// Standard deviation of one period's mean, told by the scatter within periods: between these.
struct ErrorOfMean {
    double least_m;
    double most_m;
};

struct DriftSpread {
    /// Half of the 95 % half-width of the drift per period (m) found by a straight line through all
    /// positions:
    /// +-2 sigma covers 95 % also for few periods. Infinite for less than 3 periods.
    double sigma_m = 0;
    double jitter_m = 0;      // standard deviation of D from period to period, most likely value
    double mean_error_m = 0;  // standard deviation of one period's mean apart from that, most likely value
    /// Change of D over the run by a straight line, m, with t = value / standard error on `freedom` degrees.
    double trend_m = 0;
    double trend_t = 0;
    int freedom = 0;
};

/// Model: y_k = sum of D_j up to the middle of period k, plus an independent error; D_j = D + jitter.
/// Differences of successive means then have variance jitter^2/2 + 2 error^2 and covariance jitter^2/4 -
/// error^2 with the next. `told`: what the scatter within periods says of the error. Both unknowns are
/// averaged over, weighted by restricted likelihood, so that neither noise nor jitter of the drift leaves
/// sigma too small. Where jitter cannot be told from white noise sigma is up to 3 times the line's own
/// scatter. O(periods).
DriftSpread drift_spread(std::span<const PeriodMean> means, const ErrorOfMean& told);

/// Half-width that |t| on n degrees of freedom keeps within with 95 %, over 2: what a standard error is
/// widened by.
double few_periods_factor(int freedom);

}  // namespace shaker
