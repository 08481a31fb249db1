#include "drivers/walker/walker_setting.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <sstream>
#include <vector>

#include "drivers/errors.hpp"

namespace shaker::walker {

namespace {

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

}  // namespace

WalkerSetting checked(const WalkerSetting& s) {
    require(s.frequency >= 1e-3 && s.frequency <= 1e5, "frequency (Hz)", s.frequency, "0.001 to 100000");
    require(s.g > 0 && s.g <= 1e3, "g (m/s^2)", s.g, "above 0, up to 1000");
    require(std::abs(s.tilt) < std::numbers::pi / 2, "tilt (rad)", s.tilt, "between -pi/2 and pi/2");
    check(s.friction, s.frequency);
    for (int q = 1; q <= max_harmonics; ++q) {
        const double base = std::abs(s.base.at(q)), vertical = std::abs(s.vertical.at(q));
        require(base <= 1e6, "a base harmonic (m/s^2)", base, "up to 1e6");
        require(vertical <= 1e6, "a vertical harmonic (m/s^2)", vertical, "up to 1e6");
    }
    check_contact(s);
    return s;
}

TrigPolynomial base_velocity(const WalkerSetting& s) {
    using namespace std::complex_literals;
    const double w = two_pi * s.frequency;
    auto v = s.base.a;
    for (std::size_t i = 0; i < v.size(); ++i) v[i] /= 1i * static_cast<double>(i + 1) * w;
    return {0, v};
}

}  // namespace shaker::walker
