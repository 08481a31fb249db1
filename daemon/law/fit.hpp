#pragma once
// Fit: one fitted quantity.
#include <cmath>
#include <string>
#include <vector>

#include "calibration/estimate.hpp"

namespace shaker::law {

/// A fitted quantity. NaN with the reason in `note` when it could not be determined.
struct Fit {
    std::string name{};
    double value = NAN;
    double error = NAN;  // standard error, from the errors of the points; a misfit widens that of a cosine
    double truth = NAN;  // of a place where the true v_D of a simulated bench is 0; NaN: not known, or none
    std::string unit{};  // SI, UDUNITS text
    double chi2 = NAN;   // of the whole fit
    int freedom = 0;     // degrees of freedom of chi2
    int points = 0;
    std::string note{};    // one sentence; empty: nothing to remark
    bool refused = false;  // the data refuse the law of which it is a parameter
    double gamma = NAN;    // m/s^2, for a fit at one gamma
    double phi = NAN;      // rad, for a fit at one phase
    std::string series{};  // name in the plan; empty: all
};

/// Parameters that were fitted together: names and covariance, row by row.
struct Covariance {
    std::vector<std::string> names;
    std::vector<double> values;
};

}  // namespace shaker::law
