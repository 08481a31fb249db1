#pragma once
// mu_k from the walker's acceleration in slip, without any model of v_D; and mu_ns, the paper's definition.
#include <span>
#include <vector>

#include "daemon/law/fit.hpp"
#include "daemon/law/point.hpp"

namespace shaker::law {

/// The middle of one slip of a point's cycle.
struct SlipPiece {
    const Point* point = nullptr;
    int sign = 1;                     // of v_R
    double from = 0, to = 0;          // phases t/T; `to` may exceed 1
    double v_R = 0;                   // mean, m/s
    calibration::Estimate a{};        // acceleration, m/s^2
    calibration::Estimate viscous{};  // c of a = .. - c v_R, 1/s; 0 for Coulomb's law
};

/// Pieces of the slips of a cycle that end at least 4.5 frames from the next kink, where the cycle's
/// smoothing (7 frames) and interpolation do not see it, and are 6 frames or 0.1 T long. Kinks: zeros of v -
/// v_B, and the ends of stick. Empty where the frames are too few. A piece of 2 n frames or more, n =
/// `frames`, is divided into equal pieces of at least n frames.
std::vector<SlipPiece> slip_pieces(const Point& point, double frames = HUGE_VAL);

struct SlopeFit {
    Fit mu, tilt;  // mu_k, and rad: fitted together
    Fit viscous;   // mean c of friction c v_R in slips, 1/s
    Covariance covariance;
};

/// a = g sin b - s mu_k g cos b in slip with sign s; weighted least squares over all pieces, for mu_k and the
/// tilt b (small). A parabola is fitted to x in each piece.
SlopeFit fit_slopes(std::span<const Point> points, double g = paper_g);

/// Friction against the velocity of slip, without a law: mu = s (g sin b - a)/(g cos b) in short pieces of
/// slips with acceleration a, collected by v_R.
struct FrictionAt {
    double v_R = 0;            // mean of the pieces, m/s; its sign is the direction
    calibration::Estimate mu;  // the error contains the scatter of the pieces
    int pieces = 0;
};
/// tilt: b, rad. Three pieces or more each, by v_R; |v_R| in steps of a factor 1.6. A bin's mu is the mean
/// over its velocities. Velocities in which no slip stays for 6 frames between kinks are missing.
std::vector<FrictionAt> friction_by_velocity(std::span<const Point> points, double g, double tilt);

/// mu_ns: Eq. (8), Theta = 2 asin(pi mu g/gamma), fitted to Theta = phi_0 - pi/2 of all gammas with equal
/// weights, as in the paper; the error is that of the fit, from the scatter of the Theta (the paper's
/// interval of 95 % is twice as large). The walker always sticks at the null, where Eq. (8) does not hold:
/// mu_ns is 13 to 23 % below the mu of Coulomb's law. nulls: of null_phases(). mu_ac: NaN, or the mu for
/// which the note states the bias.
Fit fit_no_stick(std::span<const Fit> nulls, double mu_ac, double g = paper_g);

}  // namespace shaker::law
