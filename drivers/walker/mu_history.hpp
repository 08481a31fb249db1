#pragma once
// MuHistory: the factor of mu from period to period.
#include <random>

#include "drivers/walker/friction.hpp"

namespace shaker::walker {

/// Factors of mu_k and mu_s in successive periods, as MuChange defines them. Equal settings give equal
/// factors.
class MuHistory {
public:
    /// period: time between two factors, s.
    MuHistory(const MuChange& change, double period);
    /// The factor of the next period; the first call gives that of period 0.
    double next();

private:
    MuChange change_;
    double period_;
    double renewal_;  // sqrt(1 - memory^2)
    std::mt19937_64 random_;
    std::normal_distribution<double> normal_;
    double z_ = 0;
    double k_ = 0;  // periods so far
};

}  // namespace shaker::walker
