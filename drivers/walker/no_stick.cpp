#include "drivers/walker/no_stick.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <vector>

#include "drivers/trig_polynomial.hpp"

namespace shaker::walker {

namespace {

using Amplitudes = std::array<std::complex<double>, max_harmonics>;

/// v_B = integral of a_B, from all harmonics or those of one parity.
TrigPolynomial base_velocity(const Harmonics<Acceleration>& base, double omega, bool odd, bool even) {
    using namespace std::complex_literals;
    Amplitudes v{};
    for (int q = 1; q <= max_harmonics; ++q) {
        if (q % 2 == 1 ? odd : even) v[static_cast<std::size_t>(q - 1)] = base.at(q) / (1i * (q * omega));
    }
    return {0, v};
}

double wrapped(double phase) { return phase - two_pi * std::floor(phase / two_pi); }

/// The two slips that begin at one shift time.
class TwoSlips {
public:
    TwoSlips(const Harmonics<Acceleration>& base, double omega, double mu_g, double start)
        : a_{0, base.a},
          v_{base_velocity(base, omega, true, true)},
          omega_{omega},
          mu_g_{mu_g},
          start_{start} {}

    /// The reason for which the solution is not valid; empty when valid.
    [[nodiscard]] std::string objection() const {
        std::ostringstream why;
        const double here = a_(start_), half_later = a_(start_ + std::numbers::pi);
        if (!(here > mu_g_)) {
            why << "a_B(t0) = " << here << " m/s^2 is not above mu g = " << mu_g_
                << ", so the walker sticks at t0";
        } else if (!(half_later < -mu_g_)) {
            why << "a_B(t0 + T/2) = " << half_later << " m/s^2 is not below -mu g = " << -mu_g_
                << ", so the walker sticks at t0 + T/2";
        } else if (const double early = first_early_match(); early >= 0) {
            why << "v_R is zero again at t/T = " << wrapped(early) / two_pi
                << ", before the end of its half period";
        }
        return why.str();
    }

private:
    /// v_R has a zero within a half only if it has the wrong sign at one of its extrema there.
    [[nodiscard]] double first_early_match() const {
        for (const double sign : {1.0, -1.0}) {  // of dv/dt
            const double from = start_ + (sign > 0 ? 0 : std::numbers::pi);
            TrigPolynomial rate = a_;  // of -v_R
            rate.mean = -sign * mu_g_;
            for (const double extremum : sign_changes(rate)) {
                const double since = wrapped(extremum - from);
                if (since >= std::numbers::pi) continue;
                const double v_R = v_(from) + sign * mu_g_ * since / omega_ - v_(extremum);
                if (sign * v_R >= 0) return extremum;
            }
        }
        return -1;
    }

    TrigPolynomial a_, v_;
    double omega_, mu_g_, start_;
};

// pi / sin(Theta/2) = Gamma + sqrt(Gamma) h(1/sqrt(Gamma)); h is smooth, and this is its Chebyshev series
// over the range. Computed from nulls of the event-driven walker at 60 Chebyshev nodes; tests compare it with
// that walker.
constexpr std::array coulomb_series{7.1200771764e-01, 3.5237467185e-01, 1.2758968452e-01, 1.4282146623e-02,
                                    5.5843524035e-03, 1.6920235047e-03, 7.3201159755e-04, 2.3230058564e-04,
                                    8.0562639940e-05, 3.1429941472e-05, 1.3085061272e-05, 4.7557195675e-06,
                                    1.6798805471e-06, 6.5605818817e-07, 2.6823174086e-07, 9.9803512012e-08};

}  // namespace

double v_rms(const Harmonics<Acceleration>& base, double frequency) {
    double squares = 0;
    for (int q = 1; q <= max_harmonics; ++q) squares += std::norm(base.at(q) / (q * two_pi * frequency)) / 2;
    return std::sqrt(squares);
}

NoStick no_stick(const Harmonics<Acceleration>& base, double frequency, double mu, double g) {
    const double omega = two_pi * frequency, mu_g = mu * g;
    TrigPolynomial match = base_velocity(base, omega, true, false);  // v_B(t0 + T/2) - v_B(t0) = mu g T/2
    const TrigPolynomial acceleration = match.derivative();          // of the odd harmonics, times 1/omega
    match.mean = mu_g / frequency / 4;
    std::vector<double> starts = sign_changes(match);
    std::erase_if(starts, [&](double phase) { return acceleration(phase) <= 0; });

    NoStick result;
    if (starts.empty()) {
        result.reason = match.order == 0
                            ? "the drive has no odd harmonic, so no shift time exists"
                            : "friction is too large for a slip of T/2: no shift time exists and the "
                              "walker must stick";
        return result;
    }
    std::sort(starts.begin(), starts.end(),
              [&](double a, double b) { return acceleration(a) > acceleration(b); });
    double start = starts.front();
    for (const double candidate : starts) {
        if (!TwoSlips{base, omega, mu_g, candidate}.objection().empty()) continue;
        start = candidate;
        break;
    }
    result.reason = TwoSlips{base, omega, mu_g, start}.objection();
    result.valid = result.reason.empty();
    result.t0 = start / two_pi;
    if (match.order == 1) result.theta = 2 * std::asin(std::numbers::pi * mu_g / (2 * std::abs(base.at(1))));
    result.v_D = base_velocity(base, omega, false, true)(start);
    result.efficiency = std::abs(result.v_D) / v_rms(base, frequency);
    return result;
}

double no_stick_theta(double gamma, double mu, double rho, double g) noexcept {
    return 2 * std::asin(std::numbers::pi * mu * g / (2 * rho * gamma));
}

double mu_from_no_stick_theta(double theta, double gamma, double rho, double g) noexcept {
    return 2 * rho * gamma * std::sin(theta / 2) / (std::numbers::pi * g);
}

double coulomb_theta(double Gamma) noexcept {
    if (!(Gamma >= coulomb_theta_from && Gamma <= coulomb_theta_to))
        return std::numeric_limits<double>::quiet_NaN();
    const double low = 1 / std::sqrt(coulomb_theta_to), high = 1 / std::sqrt(coulomb_theta_from);
    const double x = (2 / std::sqrt(Gamma) - low - high) / (high - low);
    double b1 = 0, b2 = 0;  // Clenshaw
    for (std::size_t k = coulomb_series.size() - 1; k > 0; --k) {
        const double b0 = 2 * x * b1 - b2 + coulomb_series[k];
        b2 = b1;
        b1 = b0;
    }
    const double h = x * b1 - b2 + coulomb_series[0];
    return 2 * std::asin(std::numbers::pi / (Gamma + std::sqrt(Gamma) * h));
}

}  // namespace shaker::walker
