#pragma once
// v_D by Coulomb's law against gamma or phi, with the band that the error of mu leaves: for plots.
#include <vector>

#include "calibration/estimate.hpp"
#include "drivers/drive.hpp"

namespace shaker::law {

/// v_D in m/s at each drive of a curve. NaN: there is no settled motion, or no shift time exists.
struct LawValues {
    std::vector<double> at_mu;
    std::vector<double> low, high;  // least and largest v_D for mu - sigma, mu and mu + sigma
};

struct LawCurve {
    std::vector<double> x;  // gamma in m/s^2, or phi in rad
    LawValues exact;        // Coulomb's law, stick included
    LawValues closed_form;  // without stick
};

/// The same drives with another gamma: `count` values from 0 to `to`, m/s^2. The base is level and has no
/// harmonics but the asked ones; the walker does not push it. g in m/s^2.
LawCurve against_gamma(const Drive& at, double to, std::size_t count, const calibration::Estimate& mu,
                       double g);
/// The same with another phi: `count` values from -pi to pi.
LawCurve against_phi(const Drive& at, std::size_t count, const calibration::Estimate& mu, double g);

}  // namespace shaker::law
