#pragma once
// The paper's closed forms for a walker that never sticks, and the phase of the largest drift.
#include <limits>
#include <string>

#include "drivers/drive.hpp"

namespace shaker::walker {

/// Root mean square of the base's velocity, m/s. For the paper's drive at rho = 1/2: sqrt(5/32) gamma /
/// omega.
double v_rms(const Harmonics<Acceleration>& base, double frequency);

/// The no-stick motion on a level base: two slips per period, each T/2 long, with v_R = v - v_B of either
/// sign.
struct NoStick {
    bool valid = false;  // true: exact motion of a walker with mu_k = mu_s = mu; false: approximation
    std::string reason;  // why it is not valid; empty when valid
    // NaN where no shift time exists:
    double t0 = std::numeric_limits<double>::quiet_NaN();     // t/T at which the forward acceleration begins
    double theta = std::numeric_limits<double>::quiet_NaN();  // rad; also NaN with odd harmonics above 1
    double v_D = std::numeric_limits<double>::quiet_NaN();    // m/s
    double efficiency = std::numeric_limits<double>::quiet_NaN();  // |v_D| / V_RMS
};

/// The paper's Eqs. (4), (5) and, for any harmonics, (9). Shift time t0: the odd harmonics of v_B sum to -mu
/// g T/4 while their acceleration is positive. Of several solutions the valid one is used: a_B(t0) > mu g,
/// a_B(t0 + T/2) < -mu g, and v_R has no other zero in either half. (Opposite signs of a_B alone, as in the
/// paper, do not separate the root from its mirror image.) If none is valid, the solution with the largest
/// acceleration of the odd harmonics, with the reason. mu >= 0; g in m/s^2.
NoStick no_stick(const Harmonics<Acceleration>& base, double frequency, double mu, double g = paper_g);

/// Phase of the largest drift without stick, Eq. (8) for any rho: Theta = 2 asin(pi mu g / (2 rho gamma)),
/// rad. NaN if the argument exceeds 1: no shift time exists and the walker must stick. gamma in m/s^2.
double no_stick_theta(double gamma, double mu, double rho = 0.5, double g = paper_g) noexcept;
/// Inverse of Eq. (8): mu for a Theta in [0, pi].
double mu_from_no_stick_theta(double theta, double gamma, double rho = 0.5, double g = paper_g) noexcept;

/// Range of Gamma = gamma/(mu g) in which coulomb_theta() is defined.
inline constexpr double coulomb_theta_from = 2.5;
inline constexpr double coulomb_theta_to = 1000;

/// Theta = phi_0 - pi/2 of a walker with Coulomb friction, stick included (mu_s = mu_k = mu, rho = 1/2, level
/// base); phi_0 is the null of v_D with dv_D/dphi < 0. The walker always sticks at the null, so Eq. (8) does
/// not hold there: its fit to such data gives a mu 14 to 22 % too small. Relative error below 1e-7; decreases
/// with Gamma; NaN outside the range.
double coulomb_theta(double Gamma) noexcept;

}  // namespace shaker::walker
