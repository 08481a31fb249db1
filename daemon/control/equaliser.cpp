#include "daemon/control/equaliser.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/errors.hpp"

namespace shaker {

namespace {
// Below this share of the target, harmonic 1 (or 2 where the target has no 1) is taken for missing: an open
// sensor.
constexpr double least_motion = 0.1;
}  // namespace

double peak(const Harmonics<Voltage>& volts) {
    constexpr int points = 512;
    double largest = 0;
    double before = value_at(volts, -two_pi / points), here = value_at(volts, 0);
    for (int i = 0; i < points; ++i) {
        const double after = value_at(volts, two_pi * (i + 1) / points);
        const double curve = before - 2 * here + after, slope = 0.5 * (after - before);
        const bool turning = std::abs(slope) < std::abs(curve);
        largest = std::max(largest, std::abs(turning ? here - 0.5 * slope * slope / curve : here));
        before = here;
        here = after;
    }
    return largest;
}

Equaliser::Equaliser(const Harmonics<Acceleration>& target,
                     const std::array<std::complex<double>, max_harmonics>& response,
                     const EqualiserSettings& settings)
    : target_{target}, response_{response}, settings_{settings} {
    for (int q = 1; q <= settings_.harmonics; ++q) {
        const std::complex<double> h = response_[static_cast<std::size_t>(q - 1)];
        if (!(std::abs(h) > 0) || !std::isfinite(std::abs(h)))
            throw InputError{"response of the shaker at harmonic " + std::to_string(q) +
                             " is zero or not finite"};
        volts_.at(q) = target_.at(q) / h;
    }
    keep_within_limit();
}

// Scales drive and target together: the shape stays, gamma is reduced and reported. This is also what keeps
// the integral from winding up against the limit.
void Equaliser::keep_within_limit() {
    const double over = peak(volts_) / settings_.volts_limit;
    if (over <= 1) return;
    for (int q = 1; q <= max_harmonics; ++q) {
        volts_.at(q) /= over;
        target_.at(q) /= over;
    }
    reached_ /= over;
}

Equaliser::Report Equaliser::update(const Harmonics<Acceleration>& measured, double sd) {
    Report report;
    report.reached = reached_;
    const int lead = std::abs(target_.at(1)) > 0 ? 1 : 2;
    double gamma = 0;
    for (int q = 1; q <= settings_.harmonics; ++q) gamma += std::abs(target_.at(q));
    const bool finite =
        std::ranges::all_of(measured.a, [](const auto& a) { return std::isfinite(std::abs(a)); });
    if (!finite || !std::isfinite(sd) || !(gamma > 0) ||
        std::abs(measured.at(lead)) < least_motion * std::abs(target_.at(lead)))
        return report;
    const double late = (std::arg(target_.at(lead)) - std::arg(measured.at(lead))) / lead;
    report.noise = sd / gamma;
    report.locked = true;
    for (int q = 1; q <= settings_.harmonics; ++q) {
        const std::complex<double> error = target_.at(q) - measured.at(q) * std::polar(1.0, q * late);
        double& residual = report.residual[static_cast<std::size_t>(q - 1)];
        residual = std::abs(error) / gamma;
        report.locked = report.locked && residual < std::max(settings_.lock_amplitude, 3 * report.noise);
        volts_.at(q) += settings_.gain * error / response_[static_cast<std::size_t>(q - 1)];
    }
    keep_within_limit();
    report.reached = reached_;
    return report;
}

}  // namespace shaker
