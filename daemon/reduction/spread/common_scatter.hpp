#pragma once
// Errors of the drifts of one walker in several records, by the scatter that all of them show together.
#include <span>
#include <vector>

#include "daemon/reduction/spread/drift_likelihood.hpp"

namespace shaker::reduction {

struct WalkerRecord {
    std::vector<PeriodMean> means;  // of its whole periods, without gaps; at least 3
    int periods = 0;                // of the drift
    double white_m = 0;             // as in ScatterPrior
    double response_m = 0;          // change of D for a relative change of the friction by 1
};

/// Standard error of the drift of each record, m per period, as DriftSpread::sigma_m.
/// Model: drift_likelihood.hpp, with the same three numbers for all records: error of a mean over white_m,
/// jitter over response_m, memory. A record averages over its own three, weighted by its likelihood, by what
/// the likelihoods of the others say, and by a prior: a few periods alone show neither slight jitter nor
/// memory, many records of a few periods do. A few records leave the prior as wide as it is. Records differ:
/// each of the three numbers by about a quarter, and one record in 20 has a scatter of its own.
///
/// Prior, wider than that of drift_spread(), since many records narrow it:
/// - error of a mean: white_m, or, with a hundredth of that weight, any magnitude up to 20 times it
/// - jitter: none, with weight 2.5; else any magnitude from 1e-4 to 0.6 of response_m, with weight 1 for each
///   factor of e, and 0.5 below 0.003
/// - memory r: none, with weight 0.6; else any (1 + r)/(1 - r) up to 200
std::vector<double> common_sigmas(std::span<const WalkerRecord> records);

}  // namespace shaker::reduction
