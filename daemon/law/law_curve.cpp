#include "daemon/law/law_curve.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "daemon/law/pushed_walker.hpp"
#include "drivers/errors.hpp"
#include "drivers/walker/no_stick.hpp"

namespace shaker::law {

namespace {

double exact(const Drive& drive, double mu, double g) {
    if (drive.gamma == 0) return 0;
    try {
        return pushed_cycle(harmonics(drive), drive.frequency, Coulomb{.mu = mu, .g = g}).v_D;
    } catch (const InputError&) {
        return NAN;
    }
}

double closed_form(const Drive& drive, double mu, double g) {
    return walker::no_stick(harmonics(drive), drive.frequency, mu, g).v_D;
}

template <class Law>
void add(LawValues& values, Law law, const Drive& drive, const calibration::Estimate& mu, double g) {
    const double v = law(drive, mu.value, g);
    const double error = std::isfinite(mu.sigma) ? std::min(mu.sigma, 0.99 * mu.value) : 0;
    std::array<double, 2> sides{v, v};
    if (error > 0) sides = {law(drive, mu.value - error, g), law(drive, mu.value + error, g)};
    values.at_mu.push_back(v);
    values.low.push_back(std::fmin(v, std::fmin(sides[0], sides[1])));
    values.high.push_back(std::fmax(v, std::fmax(sides[0], sides[1])));
}

LawCurve curve(Drive drive, double Drive::*member, double from, double to, std::size_t count,
               const calibration::Estimate& mu, double g) {
    LawCurve found;
    for (std::size_t i = 0; i < count; ++i) {
        drive.*member = from + (to - from) * static_cast<double>(i) / static_cast<double>(count - 1);
        found.x.push_back(drive.*member);
        add(found.exact, exact, drive, mu, g);
        add(found.closed_form, closed_form, drive, mu, g);
    }
    return found;
}

}  // namespace

LawCurve against_gamma(const Drive& at, double to, std::size_t count, const calibration::Estimate& mu,
                       double g) {
    return curve(at, &Drive::gamma, 0, to, count, mu, g);
}

LawCurve against_phi(const Drive& at, std::size_t count, const calibration::Estimate& mu, double g) {
    return curve(at, &Drive::phi, -std::numbers::pi, std::numbers::pi, count, mu, g);
}

}  // namespace shaker::law
