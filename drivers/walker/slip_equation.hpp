#pragma once
// SlipEquation: the equation of relative motion of walker and base under any law of friction.
#include <algorithm>
#include <array>

#include "drivers/trig_polynomial.hpp"
#include "drivers/walker/rough_surface.hpp"
#include "drivers/walker/walker_setting.hpp"

namespace shaker::walker {

/// Sign of a slip, and the place and the state of the contact where it began.
struct SlipStart {
    int sign = 1;
    double u = 0;
    double zeta = 0;  // law dahl
};

/// d v_R/dt = g sin b - a_B(t) - mu_k n(t) b r - c v_R, with r of FrictionLaw. Variables without unit: w =
/// v_R/V, u = omega x_R/V, theta = omega t; V = (gamma + g)/omega. During a slip the sign s of v_R is fixed,
/// so the equation is smooth across the end of the slip. Law dahl is solved for zeta: zeta(u) = s b + (zeta_0
/// - s b) exp(-s (x_R - x_0)/s_0).
class SlipEquation {
public:
    /// The setting must be checked.
    explicit SlipEquation(const WalkerSetting& setting);

    /// Multiplies mu_k and mu_s.
    void set_mu_factor(double factor) noexcept { mu_factor_ = factor; }
    /// Place on the base at u = 0, m.
    void set_place(double place) noexcept { place_ = place; }

    using Pair = std::array<double, 2>;
    using Triple = std::array<double, 3>;
    /// dw/dtheta and du/dtheta; laws coulomb, logarithmic and dahl.
    [[nodiscard]] Pair rates(double theta, double w, double u, const SlipStart& start) const noexcept;
    /// dw/dtheta, du/dtheta and dzeta/dtheta; law lugre.
    [[nodiscard]] Triple bristle_rates(double theta, const Triple& y, int sign) const noexcept;
    /// zeta of law dahl at u.
    [[nodiscard]] double dahl_zeta(double u, const SlipStart& start) const noexcept;

    /// a_B - g sin b: the acceleration that friction must give to a walker at rest on the base, m/s^2.
    [[nodiscard]] double needed(double theta) const noexcept { return a_base_(theta) - pull_; }
    /// Acceleration that static friction can give at u after a rest of this many seconds, m/s^2.
    [[nodiscard]] double holds(double theta, double u, double rest_s) const noexcept;

    [[nodiscard]] const WalkerSetting& setting() const noexcept { return setting_; }
    [[nodiscard]] double unit_velocity() const noexcept { return V_; }  // m/s
    [[nodiscard]] double omega() const noexcept { return omega_; }      // rad/s
    [[nodiscard]] double metres(double u) const noexcept { return u * V_ / omega_; }
    [[nodiscard]] int order() const noexcept { return std::max({a_base_.order, n_.order, 1}); }

private:
    [[nodiscard]] double strengthened(double speed) const noexcept;
    [[nodiscard]] double grip(double theta, double u) const noexcept;

    WalkerSetting setting_;
    RoughSurface surface_;
    TrigPolynomial a_base_, n_;
    double pull_;   // g sin b, m/s^2
    double omega_;  // rad/s
    double V_;      // m/s
    double mu_factor_ = 1;
    double place_ = 0;
};

}  // namespace shaker::walker
