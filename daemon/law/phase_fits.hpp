#pragma once
// Fits of v_D against phi and against gamma: the paper's cosine, null phases, the gamma of reversal, the
// threshold of motion.
#include <span>
#include <vector>

#include "daemon/law/fit.hpp"
#include "daemon/law/point.hpp"

namespace shaker::law {

/// v_D = v_D* cos(phi - Theta*) at one gamma, as in the paper's Fig. 3(a).
struct CosineFit {
    Fit amplitude, theta;   // v_D*, m/s, positive; Theta*, rad in (-pi, pi]
    Covariance covariance;  // of v_D* and Theta*
    double rms = NAN;       // of the residuals, m/s
};

/// One fit for each series and gamma whose phases, taken modulo pi, leave no gap above 75 deg. All points
/// have the same weight: Coulomb's v_D(phi) is not a cosine (1 to 3 % of v_D*), so the most exact points
/// would decide alone. Errors are those of v_D and of phi, propagated, and the misfit: the scatter of the
/// residuals over n - 2, taken as independent. On a level base Theta* is 0.008 to 0.01 rad below the null
/// phase minus pi/2.
std::vector<CosineFit> cosine_fits(std::span<const Point> points);

/// Null phases phi_0 with dv_D/dphi < 0, one fit for each gamma with rho = 1/2 and no overtones; `value` in
/// rad, 0 to 2 pi. A mirror partner counts at phi - pi with -v_D; both have equal weight, which cancels a
/// tilt to first order. A polynomial in phi through the points within 0.36 rad of the null: cubic, or
/// quadratic for three phases, or a line for two. The error includes the error of phi, and for a line the
/// curvature that it can miss. A null without a point on either side within that distance is left out. The
/// null is that of the bench: the push of the walker moves it by up to -1.5 mrad (0.68 g).
std::vector<Fit> null_phases(std::span<const Point> points);

/// gamma at which v_D changes sign, one fit for each phase at which it does, m/s^2. With a law: between the
/// two points beside the change, the law on the asked drive plus the distance of the points from it, linear
/// in gamma; the error includes a bend of that distance. Without: a cubic through the four nearest points in
/// gamma (fewer: a quadratic or a line); the error includes the difference from the polynomial one order
/// lower. Mirror partners count as above. The value is that of the bench, with the push of the walker.
std::vector<Fit> reversals(std::span<const Point> points, const Coulomb* law = nullptr);

/// gamma at which the walker begins to move, one fit for each phase with a point at rest: the middle between
/// the highest gamma at rest and the lowest in motion, m/s^2, with half their distance over sqrt(3) as
/// standard error (uniform). At rest: |v_D| below four errors and at rest on the base for the whole period.
/// Static friction follows: mu_s = max |a_B| / g, in the note. Without a point at rest one fit without value,
/// with the reason.
std::vector<Fit> thresholds(std::span<const Point> points, double g = paper_g);

/// Standard error of the measured phi, from those of harmonics 1 and 2, rad.
double phi_error(const Point& point) noexcept;

}  // namespace shaker::law
