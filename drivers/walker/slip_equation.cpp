#include "drivers/walker/slip_equation.hpp"

#include <algorithm>
#include <cmath>

namespace shaker::walker {

SlipEquation::SlipEquation(const WalkerSetting& setting)
    : setting_{setting},
      surface_{setting.friction.roughness},
      a_base_{0, setting.base.a},
      n_{setting.g * std::cos(setting.tilt), setting.vertical.a},
      pull_{setting.g * std::sin(setting.tilt)},
      omega_{two_pi * setting.frequency},
      V_{(a_base_.bound(0) + setting.g) / omega_} {}

// mu_k n with all factors but the law's own, m/s^2.
double SlipEquation::grip(double theta, double u) const noexcept {
    return mu_factor_ * surface_.factor(place_ + metres(u)) * setting_.friction.mu_k * n_(theta);
}

// 1 + B ln(1 + speed/v_0); continued by its tangent below zero, where no walker is.
double SlipEquation::strengthened(double speed) const noexcept {
    const double ratio = speed / setting_.friction.log_velocity;
    return 1 + setting_.friction.log_share * (ratio > 0 ? std::log1p(ratio) : ratio);
}

double SlipEquation::dahl_zeta(double u, const SlipStart& start) const noexcept {
    const Friction& f = setting_.friction;
    const double limit = start.sign * f.share(start.sign);
    return limit + (start.zeta - limit) * std::exp(-start.sign * metres(u - start.u) / f.presliding);
}

SlipEquation::Pair SlipEquation::rates(double theta, double w, double u,
                                       const SlipStart& start) const noexcept {
    const Friction& f = setting_.friction;
    const double v_R = w * V_;
    double r = start.sign * f.share(start.sign);
    if (f.law == FrictionLaw::logarithmic) r *= strengthened(start.sign * v_R);
    if (f.law == FrictionLaw::dahl) r = dahl_zeta(u, start);
    return {(-needed(theta) - grip(theta, u) * r - f.viscous * v_R) / (omega_ * V_), w};
}

SlipEquation::Triple SlipEquation::bristle_rates(double theta, const Triple& y, int sign) const noexcept {
    const Friction& f = setting_.friction;
    const double v_R = y[0] * V_, ratio = v_R / f.stribeck;
    const double h = f.share(sign) * (1 + (f.mu_s / f.mu_k - 1) * std::exp(-ratio * ratio));
    const double zeta_rate = (v_R - sign * v_R * y[2] / h) / f.presliding;  // 1/s
    const double r = y[2] + f.bristle_time * zeta_rate;
    return {(-needed(theta) - grip(theta, y[1]) * r - f.viscous * v_R) / (omega_ * V_), y[0],
            zeta_rate / omega_};
}

double SlipEquation::holds(double theta, double u, double rest_s) const noexcept {
    const Friction& f = setting_.friction;
    const double surface = mu_factor_ * surface_.factor(place_ + metres(u)) * n_(theta);
    const double aged = f.ageing == 0 ? 1 : 1 + f.ageing * std::log1p(rest_s / f.ageing_s);
    return f.mu_s * f.share(needed(theta) > 0 ? -1 : 1) * aged * surface;
}

}  // namespace shaker::walker
