#include "drivers/walker/integrated_walker.hpp"

#include <boost/math/tools/toms748_solve.hpp>
#include <boost/numeric/odeint/stepper/generation.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta_dopri5.hpp>
#include <cmath>
#include <tuple>

namespace shaker::walker {

namespace {

namespace odeint = boost::numeric::odeint;

constexpr int steps_per_harmonic = 24, instants_per_harmonic = 64;
constexpr double first_step = 1e-3;   // rad, after an event
constexpr double root_width = 1e-14;  // rad

/// The first zero of `value` between a with value > 0 and b with value <= 0.
template <class Value>
double zero_between(const Value& value, double a, double b) {
    std::uintmax_t iterations = 60;
    const auto narrow = [](double low, double high) { return high - low < root_width; };
    return boost::math::tools::toms748_solve(value, a, b, narrow, iterations).second;
}

/// The first zero of a function that is positive after a, or infinity. A function that is zero at a has just
/// left it.
template <class Value>
double first_zero(const Value& value, double a, double b) {
    constexpr int pieces = 4;
    double positive = a;
    for (int i = 1; i <= pieces; ++i) {
        const double at = a + (b - a) * i / pieces;
        if (value(at) > 0) {
            positive = at;
        } else if (positive > a || value(a) > 0) {
            return zero_between(value, positive, at);
        } else if (i == pieces) {
            return b;  // it did not leave zero: the next step decides
        }
    }
    return HUGE_VAL;
}

WalkerSetting checked_tolerance(const WalkerSetting& setting, double tolerance) {
    require(tolerance >= 1e-13 && tolerance <= 1e-2, "tolerance of the integrator", tolerance,
            "1e-13 to 1e-2");
    return checked(setting);
}

}  // namespace

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

double SlipEquation::dahl_zeta(double u, const SlipStart& start) const noexcept {
    const Friction& f = setting_.friction;
    const double limit = start.sign * f.share(start.sign);
    return limit + (start.zeta - limit) * std::exp(-start.sign * metres(u - start.u) / f.presliding);
}

SlipEquation::Pair SlipEquation::rates(double theta, double w, double u,
                                       const SlipStart& start) const noexcept {
    const Friction& f = setting_.friction;
    const double v_R = w * V_;
    const double r = f.law == FrictionLaw::dahl
                         ? dahl_zeta(u, start)
                         : start.sign * f.share(start.sign) * f.at_speed(start.sign * v_R);
    return {(-needed(theta) - grip(theta, u) * r - f.viscous * v_R) / (omega_ * V_), w};
}

SlipEquation::Triple SlipEquation::bristle_rates(double theta, const Triple& y, int sign) const noexcept {
    const Friction& f = setting_.friction;
    const double v_R = y[0] * V_, h = f.share(sign) * f.at_speed(sign * v_R);
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

IntegratedWalker::IntegratedWalker(const WalkerSetting& setting, double v, double tolerance)
    : equation_{checked_tolerance(setting, tolerance)},
      v_base_{base_velocity(setting)},
      scale_{equation_.unit_velocity() - setting.g / equation_.omega()},
      tolerance_{tolerance} {
    const double v_R = v - v_base_(0.0);
    w_ = std::abs(v_R) > 1e-15 * equation_.unit_velocity() ? v_R / equation_.unit_velocity() : 0;
    if (w_ != 0) {
        contact_ = w_ > 0 ? Contact::forward : Contact::backward;
        start_.sign = w_ > 0 ? 1 : -1;
    } else {
        choose_contact(0);
    }
    events_.clear();
    now_ = {0, v, contact_};
}

// Contact after v_R = 0 at the present phase.
void IntegratedWalker::choose_contact(double rest_s) {
    w_ = 0;
    if (equation_.setting().friction.sticks()) {
        const double needed = equation_.needed(theta_);
        const bool holds = std::abs(needed) <= equation_.holds(theta_, u_, rest_s);
        return turn_to(holds ? Contact::stick : needed > 0 ? Contact::backward : Contact::forward);
    }
    const int before = contact_ == Contact::backward ? -1 : 1;
    const double rate = equation_.setting().friction.law == FrictionLaw::dahl
                            ? equation_.rates(theta_, 0, u_, {before, u_, zeta_})[0]
                            : equation_.bristle_rates(theta_, {0, u_, zeta_}, before)[0];
    turn_to((rate == 0 ? before > 0 : rate > 0) ? Contact::forward : Contact::backward);
}

void IntegratedWalker::turn_to(Contact contact) {
    if (contact != contact_) events_.push_back({theta_ / two_pi, contact_, contact});
    if (contact == Contact::stick) {
        if (contact_ != Contact::stick) rest_from_ = theta_;
    } else {
        start_ = {static_cast<int>(contact), u_, zeta_};
        step_ = std::min(step_, first_step);
    }
    contact_ = contact;
}

double IntegratedWalker::release_after(double theta) const {
    const auto margin = [&](double at) {
        return equation_.holds(at, u_, (at - rest_from_) / equation_.omega()) -
               std::abs(equation_.needed(at));
    };
    const double apart = two_pi / (instants_per_harmonic * equation_.order());
    for (double from = theta; from < two_pi;) {
        const double to = std::min(two_pi, (std::floor(from / apart + 1e-9) + 1) * apart);
        if (margin(to) < 0) return margin(from) > 0 ? zero_between(margin, from, to) : from;
        from = to;
    }
    return HUGE_VAL;
}

void IntegratedWalker::stick() {
    theta_ = release_after(theta_);
    if (theta_ > two_pi) {
        theta_ = two_pi;
        return;
    }
    turn_to(equation_.needed(theta_) > 0 ? Contact::backward : Contact::forward);
}

// Keeps v_R at the phases of relative() in [from, to) of a slip, whose w is `speed`.
template <class Speed>
void IntegratedWalker::observe_slip(double from, double to, const Speed& speed) {
    const double apart = two_pi / static_cast<double>(relative_.size());
    for (auto i = static_cast<std::size_t>(std::ceil(from / apart)); i < relative_.size(); ++i) {
        const double at = static_cast<double>(i) * apart;
        if (at >= to) return;
        relative_[i] = speed(at) * equation_.unit_velocity();
    }
}

// Integrates to the end of the slip or of the period. State: w, u and, for law lugre, zeta.
template <class Stepper, class System, class State>
void IntegratedWalker::slip_with(Stepper stepper, System system, State state) {
    const int sign = start_.sign;
    stepper.initialize(state, theta_, step_);
    State inside = state;
    const auto relative_speed = [&](double at) {
        stepper.calc_state(at, inside);
        return inside[0];
    };
    const auto speed = [&](double at) { return sign * relative_speed(at); };
    while (true) {
        const auto [from, past] = stepper.do_step(system);
        const double to = std::min(past, two_pi), zero = first_zero(speed, from, to);
        step_ = past - from;
        if (zero > to && past < two_pi) {
            observe_slip(from, past, relative_speed);
            continue;
        }
        theta_ = std::min(zero, to);
        observe_slip(from, theta_, relative_speed);
        stepper.calc_state(theta_, inside);
        w_ = inside[0];
        u_ = inside[1];
        if constexpr (std::tuple_size_v<State> == 3) zeta_ = inside[2];
        if (equation_.setting().friction.law == FrictionLaw::dahl) zeta_ = equation_.dahl_zeta(u_, start_);
        if (zero <= to) choose_contact(0);
        return;
    }
}

void IntegratedWalker::slip() {
    const double longest = two_pi / (steps_per_harmonic * equation_.order());
    step_ = std::min(step_, longest);
    const auto integrate = [&](auto state, auto rates) {
        using State = decltype(state);
        const auto stepper =
            odeint::make_dense_output(tolerance_, tolerance_, longest, odeint::runge_kutta_dopri5<State>{});
        slip_with(
            stepper, [&](const State& y, State& rate, double theta) { rate = rates(y, theta); }, state);
    };
    if (equation_.setting().friction.law == FrictionLaw::lugre) {
        return integrate(SlipEquation::Triple{w_, u_, zeta_}, [&](const SlipEquation::Triple& y, double at) {
            return equation_.bristle_rates(at, y, start_.sign);
        });
    }
    integrate(SlipEquation::Pair{w_, u_}, [&](const SlipEquation::Pair& y, double at) {
        return equation_.rates(at, y[0], y[1], start_);
    });
}

bool IntegratedWalker::jump_to(double v, double zeta) noexcept {
    const double w = (v - v_base_(0.0)) / equation_.unit_velocity();
    const bool turns = contact_ == Contact::stick || w * static_cast<double>(contact_) <= 0;
    if (w == 0 || (turns && equation_.setting().friction.sticks())) return false;
    w_ = w;
    contact_ = w > 0 ? Contact::forward : Contact::backward;
    now_.contact = contact_;
    zeta_ = zeta;
    start_ = {w > 0 ? 1 : -1, u_, zeta};
    step_ = std::min(step_, first_step);
    now_.v = v;
    return true;
}

double IntegratedWalker::advance_period() {
    events_.clear();
    std::ranges::fill(relative_, 0);
    while (theta_ < two_pi) {
        if (contact_ == Contact::stick)
            stick();
        else
            slip();
    }
    const double walked = equation_.metres(u_);
    x_before_ += walked;
    place_ += walked;
    equation_.set_place(place_);
    theta_ = 0;
    rest_from_ -= two_pi;
    start_.u -= u_;
    u_ = 0;
    ++period_;
    now_ = {x_before_, w_ * equation_.unit_velocity() + v_base_(0.0), contact_};
    return walked;
}

}  // namespace shaker::walker
