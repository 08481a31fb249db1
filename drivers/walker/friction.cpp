#include "drivers/walker/friction.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>

#include "drivers/errors.hpp"

namespace shaker::walker {

namespace {

constexpr double most_damping = 100;  // c T; e^{c t} over a period must not overflow

void within(const char* what, double value, double low, double high) {
    std::ostringstream allowed;
    allowed << low << " to " << high;
    require(value >= low && value <= high, what, value, allowed.str());
}

}  // namespace

void check(const Friction& mu, double frequency) {
    require(mu.mu_k >= 0 && mu.mu_k <= 100, "mu_k", mu.mu_k, "0 to 100");
    require(mu.mu_s >= mu.mu_k && mu.mu_s <= 100, "mu_s", mu.mu_s, "mu_k to 100");
    require(mu.viscous >= 0 && mu.viscous / frequency <= most_damping, "viscous friction (1/s)", mu.viscous,
            "0 to 100 times the frequency");
    within("mu of backward slip over mu of forward slip", mu.backward, 0.1, 10);
    within("logarithmic strengthening", mu.log_share, 0, 10);
    within("velocity of logarithmic strengthening (m/s)", mu.log_velocity, 1e-6, 10);
    within("presliding length (m)", mu.presliding, 1e-8, 1e-3);
    within("Stribeck velocity (m/s)", mu.stribeck, 1e-5, 10);
    within("bristle time (s)", mu.bristle_time, 0, 1);
    within("ageing of mu_s", mu.ageing, 0, 1);
    within("ageing time (s)", mu.ageing_s, 1e-6, 1e3);
    within("roughness", mu.roughness.share, 0, 0.2);
    within("roughness length (m)", mu.roughness.length, 1e-5, 10);
    within("jitter of mu", mu.change.jitter, 0, 0.3);
    within("memory of mu", mu.change.memory, 0, 0.9999);
    within("relaxation of mu", mu.change.relaxation, -0.9, 10);
    within("relaxation time (s)", mu.change.relaxation_s, 1e-3, 1e6);
    require(mu.law != FrictionLaw::lugre || mu.presliding >= 1e-7, "presliding length (m)", mu.presliding,
            "1e-7 or more with law lugre, whose cost grows as its inverse");
    require((mu.sticks() && mu.law != FrictionLaw::stribeck) || mu.mu_k > 0, "mu_k", mu.mu_k,
            "above 0 with law dahl, stribeck or lugre");
    require(mu.sticks() || mu.ageing == 0, "ageing of mu_s", mu.ageing, "0 with law dahl or lugre");
}

double Friction::at_speed(double speed) const noexcept {
    if (law == FrictionLaw::logarithmic) {
        const double ratio = speed / log_velocity;
        return 1 + log_share * (ratio > 0 ? std::log1p(ratio) : ratio);
    }
    if (law != FrictionLaw::stribeck && law != FrictionLaw::lugre) return 1;
    const double ratio = speed / stribeck;
    return 1 + (mu_s / mu_k - 1) * std::exp(-ratio * ratio);
}

void require(bool good, const char* what, double value, const std::string& allowed) {
    if (good) return;
    std::ostringstream message;
    message << what << " is " << value << "; must be " << allowed;
    throw InputError{message.str()};
}

RoughSurface::RoughSurface(const Roughness& roughness)
    : amplitude_{roughness.share * std::sqrt(2.0 / waves)} {
    std::mt19937_64 random{roughness.seed};
    for (std::size_t i = 0; i < waves; ++i) {
        const double octave = 2 * static_cast<double>(i) / (waves - 1.0) - 1;  // -1..1
        waves_[i].number = 2 * std::numbers::pi * std::exp2(octave) / roughness.length;
        waves_[i].phase = 2 * std::numbers::pi * static_cast<double>(random() >> 11) * 0x1p-53;
    }
}

double RoughSurface::factor(double place) const noexcept {
    if (amplitude_ == 0) return 1;
    double sum = 0;
    for (const Wave& w : waves_) sum += std::cos(w.number * place + w.phase);
    return 1 + amplitude_ * sum;
}

MuHistory::MuHistory(const MuChange& change, double period)
    : change_{change},
      period_{period},
      renewal_{std::sqrt((1 - change.memory) * (1 + change.memory))},
      random_{change.seed} {}

double MuHistory::next() {
    if (change_.none()) return 1;
    if (change_.jitter > 0) {
        const double n = normal_(random_);
        z_ = k_ == 0 ? n : change_.memory * z_ + renewal_ * n;
    }
    const double relaxed = 1 + change_.relaxation * std::exp(-k_ * period_ / change_.relaxation_s);
    k_ += 1;
    return relaxed * std::max(0.1, 1 + change_.jitter * z_);
}

}  // namespace shaker::walker
