#include "drivers/simulated/walker/walker_law.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>

#include "drivers/errors.hpp"

namespace shaker::simulated {

namespace {

/// rad; closer phases are one: roots of two polynomials that should coincide
constexpr double same_phase = 1e-13;
constexpr double most_damping = 100;  // c T; e^{c t} over a period must not overflow

using Amplitudes = std::array<std::complex<double>, max_harmonics>;

template <class Operation>
Amplitudes each(const Amplitudes& a, Operation operation) {
    Amplitudes b{};
    for (std::size_t i = 0; i < a.size(); ++i) b[i] = operation(a[i], static_cast<double>(i) + 1);
    return b;
}

void require(bool good, const char* what, double value, const char* allowed) {
    if (good) return;
    std::ostringstream message;
    message << what << " is " << value << "; must be " << allowed;
    throw InputError{message.str()};
}

void check_contact(const WalkerSetting& s) {
    const TrigPolynomial n{s.g * std::cos(s.tilt), s.vertical.a};
    std::vector<double> phases = sign_changes(n.derivative());
    phases.push_back(0);
    const double lowest =
        *std::min_element(phases.begin(), phases.end(), [&](double a, double b) { return n(a) < n(b); });
    if (n(lowest) > 0) return;
    std::ostringstream message;
    message << "the walker leaves the base: its normal force falls to " << n(lowest)
            << " m/s^2 at phase t/T = " << lowest / two_pi << "; it must stay above 0";
    throw InputError{message.str()};
}

WalkerSetting checked(const WalkerSetting& s) {
    const Friction& mu = s.friction;
    require(s.frequency >= 1e-3 && s.frequency <= 1e5, "frequency (Hz)", s.frequency, "0.001 to 100000");
    require(s.g > 0 && s.g <= 1e3, "g (m/s^2)", s.g, "above 0, up to 1000");
    require(std::abs(s.tilt) < std::numbers::pi / 2, "tilt (rad)", s.tilt, "between -pi/2 and pi/2");
    require(mu.mu_k >= 0 && mu.mu_k <= 100, "mu_k", mu.mu_k, "0 to 100");
    require(mu.mu_s >= mu.mu_k && mu.mu_s <= 100, "mu_s", mu.mu_s, "mu_k to 100");
    require(mu.viscous >= 0 && mu.viscous / s.frequency <= most_damping, "viscous friction (1/s)", mu.viscous,
            "0 to 100 times the frequency");
    for (int q = 1; q <= max_harmonics; ++q) {
        const double base = std::abs(s.base.at(q)), vertical = std::abs(s.vertical.at(q));
        require(base <= 1e6, "a base harmonic (m/s^2)", base, "up to 1e6");
        require(vertical <= 1e6, "a vertical harmonic (m/s^2)", vertical, "up to 1e6");
    }
    check_contact(s);
    return s;
}

SlipLaw slip_law(const WalkerSetting& s, int sign) {
    return SlipLaw{{.sign = sign,
                    .omega = two_pi * s.frequency,
                    .mean = s.g * (std::sin(s.tilt) - sign * s.friction.mu_k * std::cos(s.tilt)),
                    .mu_k = s.friction.mu_k,
                    .viscous = s.friction.viscous,
                    .base = s.base.a,
                    .vertical = s.vertical.a}};
}

}  // namespace

WalkerLaw::WalkerLaw(const WalkerSetting& setting)
    : setting_{checked(setting)}, slips_{slip_law(setting, -1), slip_law(setting, 1)} {
    using namespace std::complex_literals;
    const double w = omega();
    a_base_ = {0, setting_.base.a};
    v_base_ = {0, each(setting_.base.a, [w](auto a, double q) { return a / (1i * q * w); })};
    x_base_ = {0, each(setting_.base.a, [w](auto a, double q) { return -a / (q * q * w * w); })};
    v_base_at_0_ = v_base_(0.0);
    x_base_at_0_ = x_base_(0.0);
    find_zones();
}

void WalkerLaw::find_zones() {
    const double pull = setting_.g * std::sin(setting_.tilt), weight = setting_.g * std::cos(setting_.tilt);
    // Excess of a_B - g sin b over +mu_s n (backward slip), and of its negative (forward slip).
    const auto excess = [&](double sign) {
        const double mu = setting_.friction.mu_s;
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

}  // namespace shaker::simulated
