#pragma once
// One law of friction, fitted to v_D of all points and to what the walker's push leaves in the base.
#include <span>
#include <string>
#include <vector>

#include "daemon/law/coulomb_fit.hpp"
#include "daemon/law/law_cycle.hpp"

namespace shaker::law {

/// What all laws are fitted to.
struct LawData {
    std::span<const Point> points;
    const CoulombFit* coulomb = nullptr;  // errors of v_D by the harmonics, the push and its drag; a start
    calibration::Estimate tilt{};         // by gravity, rad; NaN: not known
    bool free_tilt = true;                // mirror partners or gravity show it; else level
    bool harmonics = true;                // use harmonics 9 to 16 of the base
};

struct LawFit {
    const Law* law = nullptr;
    LawSetting setting{};              // fitted
    Fit mu{};                          // kinetic, forwards, late, at the mean place
    Fit tilt{};                        // rad; NaN: not free
    std::vector<Fit> parameters{};     // of the law, in its order
    Covariance covariance{};           // of mu and these
    std::vector<double> z{};           // (measured - law) / both errors, of v_D
    double chi2 = NAN, chi2_base = 0;  // of v_D and the tilt; of harmonics 9 to 16
    int freedom = 0, freedom_base = 0;
    int free = 0;          // parameters, mu and tilt included
    std::string reason{};  // why there is no fit; empty: there is one
    [[nodiscard]] bool known() const noexcept { return reason.empty(); }
};

/// Weighted least squares by Levenberg and Marquardt from several starts, derivatives by differences;
/// parameters stay within their ranges. Not given, with the reason: no settled motion, no convergence, a
/// point without a quantity that the law needs.
LawFit fit_law(const Law& law, const LawData& data);

}  // namespace shaker::law
