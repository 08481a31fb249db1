#include "drivers/simulated/shaker_plant.hpp"

#include <algorithm>
#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>
#include <complex>
#include <numbers>

namespace shaker {

namespace {
constexpr double pi = std::numbers::pi;
}

ShakerPlant::ShakerPlant(const Scene& scene)
    : p_{scene.shaker},
      w_{scene.walker},
      h_{1 / scene.dac_rate_hz},
      downhill_{scene.gravity * std::sin(scene.tilt_deg * pi / 180)},
      normal_{scene.gravity * std::cos(scene.tilt_deg * pi / 180)} {
    for (std::size_t k = 0; k < 2; ++k) high_pass_gain_[k] = -std::expm1(-2 * pi * p_.high_pass_hz[k] * h_);
    state_.walker_x = 1e-3 * w_.start_mm;
    state_.slip = contact({0, 0, 0});
}

double ShakerPlant::walker_acceleration(int slip) const noexcept {
    return downhill_ - slip * w_.mu_k * normal_;
}

ShakerPlant::Vector ShakerPlant::derivative(const Vector& s, int slip) const noexcept {
    const auto [i, x, v] = s;
    const double free = p_.force_factor_npa * i - p_.stiffness_npm * x - p_.damping_nspm * v;
    const double mass = p_.moving_mass_kg + p_.base_mass_kg;
    // Sticking, the walker rides along and its weight's downhill part acts on both; slipping, friction pulls
    // the base the way the walker slides.
    const double a = slip == 0 ? (free + w_.mass_kg * downhill_) / (mass + w_.mass_kg)
                               : (free + slip * w_.mu_k * w_.mass_kg * normal_) / mass;
    return {(volts_ - p_.resistance_ohm * i - p_.force_factor_npa * v) / p_.inductance_h, v, a};
}

// Taylor series of the linear system: a sample is short against its fastest time constant (L/R), so ten terms
// reach rounding.
ShakerPlant::Vector ShakerPlant::advanced(const Vector& s, int slip, double t) const noexcept {
    Vector d = derivative(s, slip), sum = s;
    const Vector rest = derivative({0, 0, 0}, slip);
    double c = t;
    for (int k = 1;; ++k) {
        for (std::size_t j = 0; j < 3; ++j) sum[j] += c * d[j];
        if (k == 10) return sum;
        Vector next = derivative(d, slip);
        for (std::size_t j = 0; j < 3; ++j) d[j] = next[j] - rest[j];
        c *= t / (k + 1);
    }
}

// What follows when the relative velocity is zero: stick wins where static friction can hold.
int ShakerPlant::contact(const Vector& s) const noexcept {
    const double needed = derivative(s, 0)[2] - downhill_;
    if (std::abs(needed) <= w_.mu_s * normal_) return 0;
    return needed > 0 ? -1 : 1;
}

// Time until the contact changes, or more than `left` when it does not in this sample.
double ShakerPlant::until_change(const Vector& s, double walker_v, int slip, double left) const {
    const double a_w = walker_acceleration(slip);
    const auto margin = [&](double t) {
        const Vector end = advanced(s, slip, t);
        if (slip != 0) return slip * (walker_v + a_w * t - end[2]);
        return w_.mu_s * normal_ - std::abs(derivative(end, 0)[2] - downhill_);
    };
    if (margin(left) > 0) return 2 * left;
    // A slip begins at zero relative velocity: look just behind its start.
    double from = 0;
    if (margin(0) <= 0) {
        from = 1e-6 * left;
        if (margin(from) <= 0) return from;
    }
    std::uintmax_t iterations = 60;
    const auto [lo, hi] = boost::math::tools::toms748_solve(
        margin, from, left, [](double a, double b) { return std::abs(b - a) < 1e-16; }, iterations);
    return hi;
}

void ShakerPlant::step(double volts) {
    double y = volts;
    for (std::size_t k = 0; k < 2; ++k) {  // exact for a held input; what goes on is the sample's mean
        const double out = y - high_pass_[k];
        high_pass_[k] += high_pass_gain_[k] * out;
        const double wh = 2 * pi * p_.high_pass_hz[k] * h_;
        y = wh > 0 ? out * high_pass_gain_[k] / wh : out;
    }
    volts_ = std::clamp(p_.amplifier_gain * y, -p_.amplifier_limit_v, p_.amplifier_limit_v);

    Vector s{state_.current, state_.x, state_.v};
    double left = h_;
    // Ten changes in 20 us would be chatter; the rest of the sample is then taken in the last mode.
    for (int changes = 0; left > 0; ++changes) {
        const double t = changes < 10 ? until_change(s, state_.walker_v, state_.slip, left) : 2 * left;
        const double dt = std::min(t, left);
        const Vector end = advanced(s, state_.slip, dt);
        if (state_.slip == 0) {
            state_.walker_x += end[1] - s[1];
            state_.walker_v = end[2];
        } else {
            const double a_w = walker_acceleration(state_.slip);
            state_.walker_x += dt * (state_.walker_v + 0.5 * dt * a_w);
            state_.walker_v += dt * a_w;
        }
        s = end;
        left -= dt;
        if (t > dt) break;
        const int was = state_.slip;
        if (was != 0) state_.walker_v = s[2];
        const double needed = derivative(s, 0)[2] - downhill_;
        state_.slip = was == 0 ? (needed > 0 ? -1 : 1) : contact(s);
        ++events_;
    }
    state_.current = s[0];
    state_.x = s[1];
    state_.v = s[2];
    state_.a = derivative(s, state_.slip)[2];
}

std::array<double, 2> ShakerPlant::response(const Scene& scene, double frequency) {
    using namespace std::complex_literals;
    const ShakerTruth& p = scene.shaker;
    const std::complex<double> jw = 2i * pi * frequency;
    const double mass = p.moving_mass_kg + p.base_mass_kg;
    std::complex<double> chain = p.amplifier_gain;
    for (const double hz : p.high_pass_hz) chain *= jw / (jw + 2 * pi * hz);
    const std::complex<double> coil = p.resistance_ohm + jw * p.inductance_h;
    const std::complex<double> mechanical =
        mass * jw + p.damping_nspm + p.stiffness_npm / jw;  // force / velocity
    const std::complex<double> velocity =
        p.force_factor_npa / (coil * mechanical + p.force_factor_npa * p.force_factor_npa);
    const std::complex<double> h = chain * velocity * jw;
    return {h.real(), h.imag()};
}

}  // namespace shaker
