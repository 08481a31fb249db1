#pragma once
// The paper's closed forms: what a walker does that never sticks, and the phase where the drift is largest.
#include <limits>
#include <string>

#include "drivers/drive.hpp"

namespace shaker {

/// Root mean square of the base's velocity, m/s. For the paper's drive at rho = 1/2: sqrt(5/32) gamma/omega.
double v_rms(const Harmonics<Acceleration>& base, double frequency);

/// The no-stick motion on a level base: two slips a period, each T/2 long.
struct NoStick {
    bool valid =
        false;  // it is the exact motion of a walker with mu_k = mu_s = mu, not only an approximation
    std::string reason;  // why it is not; empty when valid
    // NaN where no shift time exists:
    double t0 = std::numeric_limits<double>::quiet_NaN();     // t/T where the forward acceleration begins
    double theta = std::numeric_limits<double>::quiet_NaN();  // rad; also NaN with odd harmonics above 1
    double v_D = std::numeric_limits<double>::quiet_NaN();    // m/s
    double efficiency = std::numeric_limits<double>::quiet_NaN();  // |v_D| / V_RMS
};

/// Paper's Eqs. (4), (5) and, for any harmonics, (9). The shift time is where the odd harmonics of v_B add up
/// to -mu g T/4 while their acceleration is positive. Of several, the one that is valid: a_B(t0) > mu g,
/// a_B(t0 + T/2) < -mu g, and v_R has no other zero in either half. (Opposite signs of a_B alone, as the
/// paper has it, do not tell the right root from its mirror.) Where none is valid, the values are of the one
/// at which the odd harmonics accelerate most, with the reason. mu >= 0; g in m/s^2.
NoStick no_stick(const Harmonics<Acceleration>& base, double frequency, double mu, double g = paper_g);

/// Phase of largest drift without stick, Eq. (8) for any rho: Theta = 2 asin(pi mu g / (2 rho gamma)), rad.
/// NaN where no shift time exists (the argument exceeds 1): the walker must stick. gamma in m/s^2.
double no_stick_theta(double gamma, double mu, double rho = 0.5, double g = paper_g) noexcept;
/// Its inverse: the mu that Eq. (8) reads from a Theta in [0, pi].
double mu_from_no_stick_theta(double theta, double gamma, double rho = 0.5, double g = paper_g) noexcept;

/// Range of Gamma = gamma/(mu g) in which coulomb_theta() is known.
inline constexpr double coulomb_theta_from = 2.5;
inline constexpr double coulomb_theta_to = 1000;

/// Theta = phi_0 - pi/2 of a walker that obeys Coulomb's law exactly, stick included (mu_s = mu_k = mu, rho =
/// 1/2, level), where phi_0 is the null of v_D with dv_D/dphi < 0. At the null there is always a stick, so
/// Eq. (8) never holds there: fits of it to such data read a mu that is 14 to 22 % too small. Relative error
/// below 1e-7; decreases with Gamma; NaN outside the range.
double coulomb_theta(double Gamma) noexcept;
/// The mu at which coulomb_theta(gamma/(mu g)) is theta; NaN where that lies outside the range.
double mu_from_coulomb_theta(double theta, double gamma, double g = paper_g) noexcept;

}  // namespace shaker
