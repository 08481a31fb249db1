#pragma once
// v_D on the asked drive: the measured v_D, corrected by the law for what the base did else.
#include <string>

#include "daemon/law/coulomb_fit.hpp"

namespace shaker::law {

/// v_D = measured + law(asked, level, no push) - law(measured base, with all harmonics, push and tilt). It
/// stands beside the plain value, never instead; no fit and no guard uses it.
struct AskedDrive {
    calibration::Estimate v_D{};  // m/s; NaN: not given
    double correction = NAN;      // m/s, also when it is refused
    double model_error = NAN;     // part of v_D's error: of the law by mu, tilt and measured harmonics, m/s
    std::string reason{};         // not given; empty when given
};

/// Largest correction, as a share of gamma/omega, and largest distance of the measured v_D from the law at
/// the measured base, in errors of both.
inline constexpr double largest_correction = 0.05, farthest_from_law = 4;

/// Not given where mu is not known, where the correction is larger than 5 % of gamma/omega, or where the law
/// misses the measured v_D by more than four errors. at: of the point, from the fit.
AskedDrive on_asked_drive(const Point& point, const LawPoint& at, const CoulombFit& fit);

}  // namespace shaker::law
