#pragma once
// mu_k from the walker's acceleration in slip, without any model of v_D; and mu_ns, the paper's definition.
#include <span>
#include <string>
#include <string_view>
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
/// ends of stick, these by two of their errors more): the error of v(t) contains what the frames do not
/// resolve there. Empty where the frames are too few, and where the walker may be at rest: |v_R| below five
/// errors of v or 0.5 % of the base's largest velocity.
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
struct Friction {
    std::vector<FrictionAt> at;  // by v_R
    calibration::Estimate tilt;  // b, rad; its error is in each mu
    std::string tilt_from;       // "by gravity", ...
};
/// By v_R, |v_R| in steps of a factor 1.6; mu is that at the mean v_R, by a line through three pieces or
/// more, else their mean. Velocities in which no slip stays for 4 frames between kinks are missing. tilt, and
/// the words where it is from; without one that has an error it is that of fit_slopes(), and else zero to 0.5
/// mrad.
Friction friction_by_velocity(std::span<const Point> points, double g, const calibration::Estimate& tilt,
                              std::string_view from);

/// mu_ns: Eq. (8), Theta = 2 asin(pi mu g/gamma), fitted to Theta = phi_0 - pi/2 of all gammas with equal
/// weights, as in the paper; the error is that of the fit, from the scatter of the Theta (the paper's
/// interval of 95 % is twice as large). The walker always sticks at the null, where Eq. (8) does not hold:
/// mu_ns is 13 to 23 % below the mu of Coulomb's law. nulls: of null_phases(). mu_ac: NaN, or the mu for
/// which the note states the bias.
Fit fit_no_stick(std::span<const Fit> nulls, double mu_ac, double g = paper_g);

}  // namespace shaker::law
