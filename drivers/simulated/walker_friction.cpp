#include "drivers/simulated/walker_friction.hpp"

#include <cmath>
#include <numbers>

namespace shaker::simulated {

WalkerFriction::WalkerFriction(const Scene& scene)
    : friction_{friction_of(scene)},
      kinetic_{scene.walker.mu_k * scene.gravity * std::cos(scene.tilt_deg * std::numbers::pi / 180)},
      hold_{scene.walker.mu_s * scene.gravity * std::cos(scene.tilt_deg * std::numbers::pi / 180)},
      sample_{1 / scene.dac_rate_hz},
      varies_{!friction_.closed_form() || friction_.viscous > 0 || !friction_.change.none()},
      history_{friction_.change, scene.walker.mu_step_s},
      surface_{friction_.roughness},
      samples_per_step_{std::max(1L, std::lround(scene.walker.mu_step_s * scene.dac_rate_hz))},
      x_{1e-3 * scene.walker.start_mm} {}

// zeta of law dahl after a further displacement of the walker on the base.
double WalkerFriction::zeta_after(double way) const noexcept {
    const int sign = way < 0 ? -1 : 1;
    const double limit = sign * friction_.share(sign);
    return limit + (zeta_ - limit) * std::exp(-std::abs(way) / friction_.presliding);
}

Grip WalkerFriction::grip_of(const RelativeMotion& middle, double mu_factor, double aged) const noexcept {
    const walker::Friction& f = friction_;
    const double kinetic = mu_factor * kinetic_, hold = mu_factor * aged * hold_;
    if (f.law == walker::FrictionLaw::dahl) {
        const double grip = kinetic * zeta_after(middle.x - x_) + f.viscous * middle.v;
        return {grip, grip, 0, 0};
    }
    const double first = kinetic * f.at_speed(0);  // at the start of a slip
    Grip grip{first, first * f.backward, hold, hold * f.backward};
    if (middle.slip == 0) return grip;
    const double speed = std::max(0.0, middle.slip * middle.v);
    double& against = middle.slip > 0 ? grip.forward : grip.backward;
    against = kinetic * f.share(middle.slip) * f.at_speed(speed) + f.viscous * speed;
    return grip;
}

Grip WalkerFriction::next(const RelativeMotion& m) {
    if (samples_++ % samples_per_step_ == 0) mu_factor_ = history_.next();
    if (friction_.law == walker::FrictionLaw::dahl) zeta_ = zeta_after(m.x - x_);
    x_ = m.x;
    rest_s_ = m.slip == 0 ? rest_s_ + sample_ : 0;
    RelativeMotion middle = m;
    middle.x += 0.5 * sample_ * m.v;
    middle.v += 0.5 * sample_ * m.a;
    const double aged =
        friction_.ageing == 0 ? 1 : 1 + friction_.ageing * std::log1p(rest_s_ / friction_.ageing_s);
    return grip_of(middle, mu_factor_ * surface_.factor(middle.x), aged);
}

void WalkerFriction::put_down(double x) noexcept {
    x_ = x;
    zeta_ = 0;
    rest_s_ = 0;
}

}  // namespace shaker::simulated
