#include "drivers/walker/walker_law.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/errors.hpp"

namespace shaker::walker {

namespace {

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
