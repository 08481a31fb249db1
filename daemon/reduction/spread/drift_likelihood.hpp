#pragma once
// Likelihood of period means: a drift whose steps have memory, seen with independent errors.
//
// y_k = a + D k + X_k + u_k / 2 + e_k,  X_{k+1} = X_k + u_k,  u_{k+1} = r u_k + sqrt(1 - r^2) jitter w_k
// y_k: mean position in period k, m; D: drift per period, m; u_k: deviation of the drift in period k, m;
// e_k: error of the mean, m, independent, normal; w_k: normal, variance 1. a and D are unknown.
// Restricted likelihood: that of the contrasts of y that do not depend on the unknown coefficients
// (Patterson and Thompson 1971), by a Kalman filter. O(periods) for each candidate.
#include <span>
#include <vector>

namespace shaker::reduction {

/// Mean position over one period, without the periodic motion (and any straight line).
struct PeriodMean {
    int k = 0;       // index of the period; increasing, gaps allowed
    double y_m = 0;  // mean
    int frames = 0;  // number of positions
};

struct Scatter {
    double error2 = 0;   // m^2, variance of e_k for the mean number of frames; inverse to the frames
    double jitter2 = 0;  // m^2, variance of u_k
    double memory = 0;   // r, 0..1
};

/// Logarithms without their constants. Only `full` is comparable between models with other coefficients.
struct LogLikelihood {
    double restricted = 0;
    double full = 0;  // maximum over the coefficients
};
/// One for each candidate. At least 3 means.
std::vector<LogLikelihood> log_likelihoods(std::span<const PeriodMean> means,
                                           std::span<const Scatter> candidates);

/// The same model with D + amplitude contraction^k: a walker that approaches its settled drift.
struct Approach {
    double log_likelihood = 0;  // full
    double settled_m = 0;       // D, m, without the straight line that `means` lack
    double settled_sd_m = 0;
    double amplitude_m = 0;  // of the first period
};
/// Sum of contraction^j over the periods before k, and half of that of period k.
double walked_in_approach(double contraction, int k);
/// contraction: above 0, below 1. At least 4 means.
std::vector<Approach> approaches(std::span<const PeriodMean> means, std::span<const Scatter> candidates,
                                 double contraction);

/// Variance of the slope of the least-squares line through the means, per period^2, for a variance of 1.
class SlopeVariance {
public:
    explicit SlopeVariance(std::span<const PeriodMean> means);
    /// From the jitter, for this memory.
    [[nodiscard]] double of_jitter(double memory) const noexcept;
    /// From the errors of the means.
    [[nodiscard]] double of_error() const noexcept { return error_; }

private:
    std::vector<double> later_;  // change of the slope for a change of the drift in each period
    double error_ = 0;
};

}  // namespace shaker::reduction
