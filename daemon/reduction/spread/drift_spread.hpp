#pragma once
// Error of a drift when positions scatter, and when the drift scatters between periods with memory.
#include <optional>
#include <span>

#include "calibration/estimate.hpp"
#include "daemon/reduction/spread/drift_likelihood.hpp"

namespace shaker::reduction {

/// Knowledge of the scatter before the periods are compared.
struct ScatterPrior {
    double white_m = 0;     // standard deviation of one period's mean, if the positions' errors are
                            // independent; from the scatter within periods
    double contrast_m = 0;  // rms of a contrast of the quarters of each period, which a steady drift cancels
                            // from and which has the same standard deviation for independent errors
    int contrasts = 0;
    double jitter_m = 0;  // usual least jitter of D, if there is any
};

/// Change of D for a relative change of the friction by 1, over the amplitude of the walker's motion at the
/// drive frequency.
inline constexpr double response_to_friction = 2.7;
/// Usual least jitter of the friction, if there is any.
inline constexpr double usual_jitter = 0.003;

/// D approaches a settled value.
struct Settling {
    calibration::Estimate drift_m;  // settled D minus that of the straight line; +-2 sigma covers 95 %
    double change_m = 0;            // of D from the first to the last period
    double weight = 1;              // probability that D does so, against a D that is settled, 0..1
};

struct DriftSpread {
    /// Half of the 95 % half-width of the drift per period (m) from a straight line through all positions:
    /// +-2 sigma covers 95 %, also for few periods. An approach to a settled value that is more likely
    /// than not does not count as scatter. Infinite for fewer than 3 periods.
    double sigma_m = 0;
    double jitter_m = 0;      // m, standard deviation of D between periods, most likely value
    double mean_error_m = 0;  // m, standard deviation of one period's mean without jitter, most likely value
    double memory = 0;        // AR(1) coefficient of D from period to period, most likely value
    /// Independent values of D among N, median: N (1 - r)/(1 + r) where jitter with memory r dominates.
    double independent = 0;
    /// At least 8 periods. One that is more likely than not is found in about 1 of 100 settled walkers.
    std::optional<Settling> settling;
};

/// Model: drift_likelihood.hpp. The unknown scatter is averaged over with the restricted likelihood as
/// weight, so that neither noise nor jitter nor memory makes sigma too small. Priors, for what a record
/// does not show:
/// - error of a mean: white_m, or, with a thirtieth of that weight, any magnitude up to all the scatter
/// - jitter: none, with weight 2.5; else any magnitude, with weight 1 for each factor of e above jitter_m and
///   0.08 below it
/// - memory: none, with weight 0.75; else (1 + r)/(1 - r) = x with density 0.2 x^-1.8, r <= 0.99
/// With fewer than about 4 independent values these decide sigma.
/// Limit: 10 (40) periods do not show jitter of up to 3 (1) times the error of a mean, though it adds more to
/// the slope's error than that does; sigma then covers 65 to 95 %. Weight 1 instead of 0.08 covers 91 %, with
/// errors twice too wide in white noise.
DriftSpread drift_spread(std::span<const PeriodMean> means, const ScatterPrior& prior);

/// Half of the 95 % quantile of |t| with n degrees of freedom: the factor that widens a standard error.
double few_periods_factor(int freedom);

}  // namespace shaker::reduction
