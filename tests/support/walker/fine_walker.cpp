#include "tests/support/walker/fine_walker.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

namespace shaker {

namespace {

constexpr long double turn_ld = 2 * std::numbers::pi_v<long double>;

long double bisect(const std::function<long double(long double)>& f, long double a, long double b) {
    const bool negative_at_a = f(a) < 0;
    for (int i = 0; i < 80; ++i) {
        const long double mid = (a + b) / 2;
        ((f(mid) < 0) == negative_at_a ? a : b) = mid;
    }
    return (a + b) / 2;
}

int sign_of(long double x) { return x > 0 ? 1 : -1; }

}  // namespace

FineWalker::FineWalker(const walker::WalkerSetting& setting, long double v, int steps)
    : setting_{setting}, omega_{turn_ld * setting.frequency}, steps_{steps}, v_{v} {
    for (int q = 1; q <= max_harmonics; ++q) {
        const std::complex<long double> b = setting.base.at(q), z = setting.vertical.at(q);
        if (b != 0.0L) base_.push_back({q, std::abs(b), std::arg(b)});
        if (z != 0.0L) vertical_.push_back({q, std::abs(z), std::arg(z)});
    }
    const long double v_rel = v - v_base(0);
    switch_to(sign_of(v_rel), 0, v, 0);
    if (std::abs(v_rel) < 1e-15L * omega_) meet_base(0);
    events_.clear();
}

long double FineWalker::a_base(long double theta) const {
    long double sum = 0;
    for (const Term& t : base_) sum += t.amplitude * std::sin(t.q * theta + t.phase);
    return sum;
}
long double FineWalker::v_base(long double theta) const {
    long double sum = 0;
    for (const Term& t : base_) sum -= t.amplitude / (t.q * omega_) * std::cos(t.q * theta + t.phase);
    return sum;
}
long double FineWalker::x_base(long double theta) const {
    long double sum = 0;
    for (const Term& t : base_)
        sum -= t.amplitude / (t.q * t.q * omega_ * omega_) * std::sin(t.q * theta + t.phase);
    return sum;
}
long double FineWalker::normal(long double theta) const {
    long double sum = setting_.g * std::cos(static_cast<long double>(setting_.tilt));
    for (const Term& t : vertical_) sum += t.amplitude * std::sin(t.q * theta + t.phase);
    return sum;
}
long double FineWalker::drive_margin(long double theta) const {
    const long double pull = setting_.g * std::sin(static_cast<long double>(setting_.tilt));
    return std::abs(a_base(theta) - pull) - setting_.friction.mu_s * normal(theta);
}

// With damping c a force of frequency qw causes a motion with a gain and a lag; without damping it is
// integrated.
long double FineWalker::v_slip(long double theta) const {
    const long double c = setting_.friction.viscous, t = (theta - start_) / omega_,
                      mu = setting_.friction.mu_k;
    const long double tilt = setting_.tilt, p = setting_.g * (std::sin(tilt) - s_ * mu * std::cos(tilt));
    const auto response = [&](long double at) {
        long double sum = 0;
        for (const Term& f : vertical_) {
            const long double w = f.q * omega_, lag = std::atan2(w, c);
            sum -= s_ * mu * f.amplitude / std::hypot(w, c) * std::sin(f.q * at + f.phase - lag);
        }
        if (c == 0) return sum;
        for (const Term& f : base_) {
            const long double w = f.q * omega_, lag = std::atan2(w, c);
            sum -= c * f.amplitude / w / std::hypot(w, c) * std::cos(f.q * at + f.phase - lag);
        }
        return sum;
    };
    const long double free = v_start_ - response(start_);
    if (c == 0) return free + p * t + response(theta);
    return free * std::exp(-c * t) - p * std::expm1(-c * t) / c + response(theta);
}

// Gauss-Legendre on pieces: independent of the closed form under test.
long double FineWalker::x_slip(long double theta) const {
    static constexpr long double node[] = {0.1252334085114689154724L, 0.3678314989981801937527L,
                                           0.5873179542866174472967L, 0.7699026741943046870369L,
                                           0.9041172563704748566785L, 0.9815606342467192506906L};
    static constexpr long double weight[] = {0.2491470458134027850006L, 0.2334925365383548087608L,
                                             0.2031674267230659217491L, 0.1600783285433462263347L,
                                             0.1069393259953184309603L, 0.0471753363865118271946L};
    const int pieces = 1 + static_cast<int>((theta - start_) * 8);
    const long double h = (theta - start_) / pieces / 2;
    long double sum = 0;
    for (int i = 0; i < pieces; ++i) {
        const long double mid = start_ + (2 * i + 1) * h;
        for (int k = 0; k < 6; ++k)
            sum += weight[k] * (v_slip(mid - h * node[k]) + v_slip(mid + h * node[k]));
    }
    return x_start_ + sum * h / omega_;
}

long double FineWalker::v_rel_rate(long double theta) const {
    const long double pull = setting_.g * std::sin(static_cast<long double>(setting_.tilt));
    return pull - s_ * setting_.friction.mu_k * normal(theta) - setting_.friction.viscous * v_rel(theta) -
           a_base(theta);
}

void FineWalker::switch_to(int s, long double theta, long double v, long double x) {
    if (s != s_) events_.push_back({theta / turn_ld, s_, s});
    s_ = s;
    start_ = theta;
    v_start_ = v;
    x_start_ = x;
}

void FineWalker::meet_base(long double theta) {
    const long double x = s_ == 0 ? x_start_ + x_base(theta) - x_base(start_) : x_slip(theta);
    const long double pull = setting_.g * std::sin(static_cast<long double>(setting_.tilt));
    const int after = drive_margin(theta) <= 0 ? 0 : -sign_of(a_base(theta) - pull);
    switch_to(after, theta, v_base(theta), x);
}

/// The margin is zero to rounding and about to become positive: the walker slips.
void FineWalker::release(long double theta) {
    const long double pull = setting_.g * std::sin(static_cast<long double>(setting_.tilt));
    switch_to(-sign_of(a_base(theta) - pull), theta, v_base(theta),
              x_start_ + x_base(theta) - x_base(start_));
}

/// s v_R at b is below zero, or has been so at an extremum between a and b. Right after the segment's start
/// v_R leaves zero, so the first step is judged from its middle.
bool FineWalker::slip_ends_in(long double a, long double b, long double& at) const {
    const auto gap = [this](long double theta) { return s_ * v_rel(theta); };
    long double left = a;
    if (a == start_) {  // find where it has clearly left
        left = a + (b - a) / 192;
        if (gap(left) <= 0) left = a;
    }
    if (gap(b) < 0) {
        if (gap(left) < 0) return at = left, true;
        at = bisect(gap, left, b);
        return true;
    }
    // Both ends are above: v_R may still have dipped below between them, where its rate turns from falling to
    // rising.
    const auto rate = [this](long double theta) { return s_ * v_rel_rate(theta); };
    if (rate(left) >= 0 || rate(b) <= 0) return false;
    const long double lowest = bisect(rate, left, b);
    if (gap(lowest) >= 0 || gap(left) <= 0) return false;
    at = bisect(gap, left, lowest);
    return true;
}

long double FineWalker::advance_period() {
    events_.clear();
    start_ = 0;
    v_start_ = v_;
    x_start_ = 0;
    for (int i = 0; i < steps_; ++i) {
        long double a = turn_ld * i / steps_;
        const long double b = turn_ld * (i + 1) / steps_;
        for (int guard = 0; guard < 8; ++guard) {
            long double at = 0;
            if (s_ != 0) {
                if (!slip_ends_in(std::max(a, start_), b, at)) break;
            } else {
                // Release inside the step, or at the tip of a margin that peaks inside it.
                const auto margin = [this](long double theta) { return drive_margin(theta); };
                long double lo = a, hi = b;
                if (margin(b) <= 0) {
                    for (int k = 0; k < 60; ++k) {
                        const long double p = lo + (hi - lo) / 3, q = hi - (hi - lo) / 3;
                        (margin(p) > margin(q) ? hi : lo) = margin(p) > margin(q) ? q : p;
                    }
                    hi = (lo + hi) / 2;
                    if (margin(hi) <= 0) break;
                }
                at = margin(a) > 0 ? a : bisect(margin, a, hi);
                release(at);
                a = at;
                continue;
            }
            meet_base(at);
            a = at;
        }
    }
    const long double D = s_ == 0 ? x_start_ + x_base(turn_ld) - x_base(start_) : x_slip(turn_ld);
    v_ = s_ == 0 ? v_base(0) : v_slip(turn_ld);
    return D;
}

}  // namespace shaker
