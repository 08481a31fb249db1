#include "daemon/law/budget.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>

namespace shaker::law {

namespace {

std::string relative(double x) { return fmt::format("{:.3g} %", 100 * x); }

Budget sorted(const Fit& fit, std::vector<Share> shares) {
    std::erase_if(shares, [](const Share& s) { return !std::isfinite(s.share); });
    std::ranges::stable_sort(shares, [](const Share& a, const Share& b) { return a.share > b.share; });
    Budget budget{.of = fit.name, .shares = std::move(shares), .value = fit.value};
    for (const Share& s : budget.shares) budget.total = std::hypot(budget.total, s.share);
    return budget;
}

// The part of the error of mu that vanishes when the tilt is known.
double by_fitted_tilt(const CoulombFit& fit) { return std::abs(fit.covariance.values[1]) / fit.tilt.error; }

}  // namespace

Budget coulomb_budget(std::span<const Point> points, const CoulombFit& fit, const InputErrors& errors) {
    if (!fit.known()) return {.of = fit.mu.name};
    double statistics = 0, harmonics = 0, gain = 0, scale = 0, tilt = 0, gravity = 0, push = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const double w = fit.gain[i];
        const LawPoint& at = fit.points[i];
        statistics = std::hypot(statistics, w * points[i].v_D.sigma);
        harmonics = std::hypot(harmonics, w * at.base_error);
        gain += w * at.by_gain;
        scale += w * points[i].v_D.value;
        tilt += w * at.by_tilt;
        gravity += w * at.by_gravity * fit.law.g;
        push += w * at.by_push;
    }
    const double mu = fit.law.mu;
    const bool fitted = std::isfinite(fit.tilt.value);
    const double push_error = std::isfinite(fit.push.error) ? fit.push.error : 0;
    const double known = fitted ? by_fitted_tilt(fit) : std::abs(tilt) * errors.tilt;
    // The tilt's part is in both sums already; it is reported apart.
    const double kept = fitted ? std::sqrt(std::max(0.0, 1 - std::pow(known / fit.mu.error, 2))) : 1;
    return sorted(
        fit.mu,
        {{"statistics", kept * statistics / mu, "errors of v_D"},
         {"harmonics", std::hypot(kept * harmonics, push * push_error) / mu,
          fmt::format("errors of the measured harmonics, m/M_eff to {:.2g}", push_error)},
         {"tilt", known / mu,
          fitted ? fmt::format("fitted to {:.2g} urad", 1e6 * fit.tilt.error)
                 : fmt::format("level to {:.2g} mrad, estimate", 1e3 * errors.tilt)},
         {"gain", std::abs(gain) * errors.gain / mu, relative(errors.gain) + ", estimate"},
         {"scale", std::abs(scale) * errors.scale / mu, relative(errors.scale) + ", estimate"},
         {"clock", 2 * std::abs(scale) * errors.clock / mu, relative(errors.clock) + ", estimate"},
         {"local g", std::abs(gravity) * errors.gravity / mu, relative(errors.gravity) + ", estimate"}});
}

Budget slope_budget(const SlopeFit& fit, const InputErrors& errors) {
    if (!std::isfinite(fit.mu.value)) return {.of = fit.mu.name};
    const double tilt = std::abs(fit.covariance.values[1]) / fit.tilt.error;
    return sorted(
        fit.mu,
        {{"statistics", std::sqrt(std::max(0.0, std::pow(fit.mu.error, 2) - tilt * tilt)) / fit.mu.value,
          "errors of x(t)"},
         {"tilt", tilt / fit.mu.value, fmt::format("fitted to {:.2g} urad", 1e6 * fit.tilt.error)},
         {"gain", 0, "no influence"},
         {"harmonics", 0, "no influence"},
         {"scale", errors.scale, relative(errors.scale) + ", estimate"},
         {"clock", 2 * errors.clock, relative(errors.clock) + ", estimate"},
         {"local g", errors.gravity, relative(errors.gravity) + ", estimate"}});
}

Budget no_stick_budget(const Fit& fit, std::span<const Fit> nulls, const InputErrors& errors) {
    if (!std::isfinite(fit.value)) return {.of = fit.name};
    // mu = gamma sin(Theta/2) / (pi g): one null moves its own mu by cot(Theta/2)/2 of it.
    double statistics = 0;
    for (const Fit& null : nulls) {
        const double half = (null.value - std::numbers::pi / 2) / 2;
        statistics = std::hypot(statistics, null.error / std::tan(half) / 2);
    }
    return sorted(
        fit, {{"model", fit.error / fit.value, "scatter of Theta about Eq. (8)"},
              {"statistics", statistics / static_cast<double>(nulls.size()), "errors of the null phases"},
              {"gain", errors.gain, relative(errors.gain) + ", estimate"},
              {"scale", 0, "no influence"},
              {"clock", 0, "no influence"},
              {"local g", errors.gravity, relative(errors.gravity) + ", estimate"}});
}

}  // namespace shaker::law
