#pragma once
// mu_k from the walker's acceleration in slip, without any model of v_D; and mu_ns, the paper's definition.
#include <span>
#include <vector>

#include "daemon/law/fit.hpp"
#include "daemon/law/point.hpp"

namespace shaker::law {

/// A part of a slip between two phases of the cycle.
struct SlipForce {
    std::size_t from = 0, to = 0;  // indices of the cycle's phases; beyond its size: of the next period
    double v_R = 0;                // mean, m/s
    calibration::Estimate a{};     // mean acceleration of the walker, m/s^2: its change of v over the time
};
/// Parts of at least 4 frames of the slips, Point::kink_frames from the next kink (zeros of v - v_B, and the
/// ends of stick): the error of v(t) contains what the frames do not resolve there. Empty where the frames
/// are too few.
std::vector<SlipForce> slip_forces(const Point& point);

struct SlopeFit {
    Fit mu, tilt;  // mu_k, and rad: fitted together
    Fit viscous;   // c of friction c v_R in slips, 1/s; 0 for Coulomb's law
    Covariance covariance;
};

/// a = g sin b - s mu_k g cos b in slip with sign s; weighted least squares over all parts, for mu_k and the
/// tilt b (small); and once more with friction c v_R.
SlopeFit fit_slopes(std::span<const Point> points, double g = paper_g);

/// Friction against the velocity of slip, without a law: mu = s (g sin b - a)/(g cos b) in parts of slips
/// with acceleration a, collected by v_R.
struct FrictionAt {
    double v_R = 0;            // mean of the pieces, m/s; its sign is the direction
    calibration::Estimate mu;  // the error contains the pieces' scatter about a line
    int pieces = 0;
};
/// tilt: b, rad. By v_R, |v_R| in steps of a factor 1.6; mu is that at the mean v_R, by a line through three
/// pieces or more, else their mean. Velocities in which no slip stays for 4 frames between kinks are
/// missing.
std::vector<FrictionAt> friction_by_velocity(std::span<const Point> points, double g, double tilt);

/// mu_ns: Eq. (8), Theta = 2 asin(pi mu g/gamma), fitted to Theta = phi_0 - pi/2 of all gammas with equal
/// weights, as in the paper; the error is that of the fit, from the scatter of the Theta (the paper's
/// interval of 95 % is twice as large). The walker always sticks at the null, where Eq. (8) does not hold:
/// mu_ns is 13 to 23 % below the mu of Coulomb's law. nulls: of null_phases(). mu_ac: NaN, or the mu for
/// which the note states the bias.
Fit fit_no_stick(std::span<const Fit> nulls, double mu_ac, double g = paper_g);

}  // namespace shaker::law
