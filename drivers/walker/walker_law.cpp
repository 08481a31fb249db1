#include "drivers/walker/walker_law.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "drivers/errors.hpp"

namespace shaker::walker {

namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();
constexpr int nodes_per_harmonic = 32;

/// (1 - e^-x)/x and (x - 1 + e^-x)/x^2, accurate near 0 too.
struct DecayIntegrals {
    double first = 1;
    double second = 0.5;
};
DecayIntegrals decay_integrals(double x) noexcept {
    if (x == 0) return {};
    const double first = -std::expm1(-x) / x;
    if (x > 0.5) return {first, (1 - first) / x};
    double term = 0.5, sum = 0.5;
    for (int n = 3; std::abs(term) > epsilon * sum; ++n) sum += term *= -x / n;
    return {first, sum};
}

/// rad; closer phases are one: roots of two polynomials that should coincide
constexpr double same_phase = 1e-13;

using Amplitudes = std::array<std::complex<double>, max_harmonics>;

template <class Operation>
Amplitudes each(const Amplitudes& a, Operation operation) {
    Amplitudes b{};
    for (std::size_t i = 0; i < a.size(); ++i) b[i] = operation(a[i], static_cast<double>(i) + 1);
    return b;
}

WalkerSetting checked_closed(const WalkerSetting& s) {
    checked(s);
    if (s.friction.closed_form()) return s;
    throw InputError{
        "this law of friction has no closed form; Coulomb's law has one, with viscous friction and "
        "without ageing and roughness"};
}

SlipLaw slip_law(const WalkerSetting& s, int sign) {
    const double mu_k = s.friction.mu_k * s.friction.share(sign);
    return SlipLaw{{.sign = sign,
                    .omega = two_pi * s.frequency,
                    .mean = s.g * (std::sin(s.tilt) - sign * mu_k * std::cos(s.tilt)),
                    .mu_k = mu_k,
                    .viscous = s.friction.viscous,
                    .base = s.base.a,
                    .vertical = s.vertical.a}};
}

}  // namespace

SlipLaw::SlipLaw(const SlipForces& forces)
    : sign_{static_cast<double>(forces.sign)},
      omega_{forces.omega},
      kappa_{forces.viscous / forces.omega},
      mean_{forces.mean} {
    using namespace std::complex_literals;
    std::array<std::complex<double>, max_harmonics> f{}, K{}, U{}, Y{};
    for (std::size_t i = 0; i < f.size(); ++i) {
        const double q = static_cast<double>(i) + 1;
        const std::complex<double> friction = sign_ * forces.mu_k * forces.vertical[i];
        const std::complex<double> v_base = forces.base[i] / (1i * q * omega_);
        f[i] = -(forces.base[i] + friction);
        K[i] = f[i] / (kappa_ + 1i * q) / omega_;
        U[i] = (forces.viscous * v_base - friction) / (forces.viscous + 1i * q * omega_);
        Y[i] = U[i] / (1i * q * omega_);
    }
    f_ = {mean_, f};
    K_periodic_ = {0, K};
    U_ = {0, U};
    Y_ = {0, Y};
    slope_bound_ = f_.bound(1) + kappa_ * (f_.bound(0) + std::abs(mean_));
    find_falling_pieces();

    const int cells = nodes_per_harmonic * std::max(2, f_.order);
    node_spacing_ = two_pi / cells;
    nodes_.reserve(static_cast<std::size_t>(cells) + 1);
    for (int i = 0; i <= cells; ++i) {
        const double phase = i * node_spacing_;
        const KAndF at = evaluate(phase, turn(phase));
        nodes_.push_back({at.K, growth(phase) * at.f / omega_});
    }
}

void SlipLaw::find_falling_pieces() {
    std::vector<double> cuts = sign_changes(f_);
    if (cuts.empty() || cuts.front() > 0) cuts.insert(cuts.begin(), 0.0);
    cuts.push_back(two_pi);
    for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
        const double from = cuts[i], to = cuts[i + 1];
        if (sign_ * f_((from + to) / 2) >= 0) continue;
        const bool seam = i + 2 == cuts.size();
        falling_.push_back({from, to, evaluate(to, seam ? Turn{} : turn(to)).K, seam});
    }
}

SlipLaw::KAndF SlipLaw::evaluate(double phase, Turn z) const noexcept {
    double periodic = 0, f = mean_;
    Turn power = z;
    for (std::size_t q = 0; q < static_cast<std::size_t>(f_.order); ++q) {
        periodic += K_periodic_.in_phase[q] * power.s + K_periodic_.quadrature[q] * power.c;
        f += f_.in_phase[q] * power.s + f_.quadrature[q] * power.c;
        power = {power.c * z.c - power.s * z.s, power.s * z.c + power.c * z.s};
    }
    if (kappa_ == 0) return {mean_ * phase / omega_ + periodic, f};
    return {mean_ / omega_ * std::expm1(kappa_ * phase) / kappa_ + std::exp(kappa_ * phase) * periodic, f};
}

Motion SlipLaw::advance(Motion m, double from, double to) const noexcept {
    const double dt = (to - from) / omega_;
    if (U_.order == 0) {  // neither viscous friction nor vertical motion: a parabola
        return {m.v + mean_ * dt, m.x + (m.v + mean_ * dt / 2) * dt};
    }
    const Turn z0 = turn(from), z1 = turn(to);
    const double free = m.v - U_(z0), decay = kappa_ * (to - from);
    const DecayIntegrals integral = decay_integrals(decay);
    return {U_(z1) + free * std::exp(-decay) + mean_ * dt * integral.first,
            m.x + Y_(z1) - Y_(z0) + (free * integral.first + mean_ * dt * integral.second) * dt};
}

SlipLaw::Zero SlipLaw::next_zero(double from, double C, double ignore_until) const noexcept {
    for (const Falling& piece : falling_) {
        if (piece.to <= ignore_until || piece.to < from) continue;
        const double end = sign_ * (C + piece.K_to);
        // A zero exactly at the seam belongs to the next period.
        if (end > 0 || (end == 0 && piece.ends_at_seam)) continue;
        return zero_in(std::max(piece.from, from), piece.to, C);
    }
    return {never, {}};
}

/// Zero between a and b of the cubic through the ends of a grid cell with their slopes.
double SlipLaw::guess(std::size_t cell, double C, double a, double b) const noexcept {
    const Node &left = nodes_[cell], &right = nodes_[cell + 1];
    const double h = node_spacing_, start = static_cast<double>(cell) * h;
    const double y0 = C + left.K, m0 = h * left.slope, m1 = h * right.slope, dy = right.K - left.K;
    const double c2 = 3 * dy - 2 * m0 - m1, c3 = m0 + m1 - 2 * dy;
    const double low = (a - start) / h, high = (b - start) / h;
    double u = std::clamp(dy == 0 ? 0.5 : -y0 / dy, low, high);
    for (int i = 0; i < 3; ++i) {
        const double slope = m0 + u * (2 * c2 + u * 3 * c3);
        if (slope == 0) break;
        u = std::clamp(u - (y0 + u * (m0 + u * (c2 + u * c3))) / slope, low, high);
    }
    return start + u * h;
}

/// Safeguarded Newton's method on a piece where s (C + K) falls from >= 0 at a to <= 0 at b.
SlipLaw::Zero SlipLaw::zero_in(double a, double b, double C) const noexcept {
    auto cell = static_cast<std::size_t>(a / node_spacing_);
    while (cell + 2 < nodes_.size()) {
        const double next = static_cast<double>(cell + 1) * node_spacing_;
        if (next >= b) break;
        if (next > a) {
            if (sign_ * (C + nodes_[cell + 1].K) <= 0) {
                b = next;
                break;
            }
            a = next;
        }
        ++cell;
    }
    double phase = guess(cell, C, a, b);
    Turn z = turn(phase);
    for (int i = 0; i < 100; ++i) {
        const auto [K, f] = evaluate(phase, z);
        const double G = C + K;
        if (G == 0) break;
        (sign_ * G > 0 ? a : b) = phase;
        const double rate = growth(phase) * f / omega_;
        double next = phase - G / rate;
        const bool newton = next >= a && next <= b;
        if (!newton) next = (a + b) / 2;
        const double step = next - phase;
        z = std::abs(step) < 1e-4 ? nudged(z, step) : turn(next);
        phase = next;
        // The error after a Newton step is at most its square times curvature / slope.
        if (std::abs(step) <= 2 * epsilon * phase) break;
        if (newton && step * step * slope_bound_ <= epsilon * std::abs(f)) break;
    }
    return {phase, z};
}

WalkerLaw::WalkerLaw(const WalkerSetting& setting)
    : setting_{checked_closed(setting)}, slips_{slip_law(setting, -1), slip_law(setting, 1)} {
    const double w = omega();
    a_base_ = {0, setting_.base.a};
    v_base_ = base_velocity(setting_);
    x_base_ = {0, each(setting_.base.a, [w](auto a, double q) { return -a / (q * q * w * w); })};
    v_base_at_0_ = v_base_(0.0);
    x_base_at_0_ = x_base_(0.0);
    find_zones();
}

void WalkerLaw::find_zones() {
    const double pull = setting_.g * std::sin(setting_.tilt), weight = setting_.g * std::cos(setting_.tilt);
    // Excess of a_B - g sin b over +mu_s n (backward slip), and of its negative (forward slip).
    const auto excess = [&](double sign) {
        const double mu = setting_.friction.mu_s * setting_.friction.share(sign > 0 ? -1 : 1);
        Amplitudes a = each(setting_.base.a, [sign](auto amplitude, double) { return sign * amplitude; });
        for (std::size_t i = 0; i < a.size(); ++i) a[i] -= mu * setting_.vertical.a[i];
        return TrigPolynomial{-sign * pull - mu * weight, a};
    };
    const TrigPolynomial backward = excess(1), forward = excess(-1);
    std::vector<double> cuts = sign_changes(backward);
    for (const double cut : sign_changes(forward)) cuts.push_back(cut);
    std::sort(cuts.begin(), cuts.end());
    if (cuts.empty() || cuts.front() > 0) cuts.insert(cuts.begin(), 0.0);
    for (std::size_t i = 0; i < cuts.size(); ++i) {
        const double from = cuts[i], to = i + 1 < cuts.size() ? cuts[i + 1] : two_pi;
        const Turn z = turn((from + to) / 2);
        const Contact contact = backward(z) > 0  ? Contact::backward
                                : forward(z) > 0 ? Contact::forward
                                                 : Contact::stick;
        if (zones_.empty() || zones_.back().contact != contact)
            zones_.push_back({from, to, contact, 0, 0, 0});
        zones_.back().to = to;
    }
    for (Zone& zone : zones_) {
        const Turn z = zone.to == two_pi ? Turn{} : turn(zone.to);
        zone.v_base_to = v_base_(z);
        zone.x_base_to = x_base_(z);
        const Contact following = next(zone).contact;
        if (following != Contact::stick) zone.C_next = -slip(following).k_at(zone.to, z);
    }
}

const WalkerLaw::Zone& WalkerLaw::zone_after(double phase) const noexcept {
    const Zone* zone = zones_.data();
    const Zone* const last = zone + zones_.size() - 1;
    while (zone != last && zone->to <= phase + same_phase) ++zone;
    return *zone;
}

const WalkerLaw::Zone& WalkerLaw::next(const Zone& zone) const noexcept {
    return &zone == &zones_.back() ? zones_.front() : *(&zone + 1);
}

}  // namespace shaker::walker
