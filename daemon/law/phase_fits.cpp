#include "daemon/law/phase_fits.hpp"

#include <spdlog/fmt/fmt.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "daemon/law/least_squares.hpp"

namespace shaker::law {

namespace {

using std::numbers::pi;

constexpr double widest_gap = 75 * pi / 180;  // between phases of a cosine fit
constexpr double near_null = 0.36;            // rad
constexpr double same_phase = 2e-3;           // rad: one phase, measured twice
constexpr double line_bias = 1e-3;  // rad: a line through points within 0.3 rad misses the null by less

bool gaps_hold(const std::vector<Folded>& group) {
    if (group.empty()) return false;
    double widest = group.front().x + pi - group.back().x;
    for (std::size_t i = 1; i < group.size(); ++i) widest = std::max(widest, group[i].x - group[i - 1].x);
    return widest <= widest_gap;
}

CosineFit cosine_fit(const std::vector<Folded>& group, double gamma, const std::string& series) {
    const auto n = static_cast<Eigen::Index>(group.size());
    Eigen::MatrixXd A(n, 2);
    Eigen::VectorXd y(n), sigma(n);
    Linear fit;
    for (int round = 0; round < 2; ++round) {  // the second with the errors of phi, which need the slope
        for (Eigen::Index i = 0; i < n; ++i) {
            const Folded& f = group[static_cast<std::size_t>(i)];
            A.row(i) << std::cos(f.x), std::sin(f.x);
            y[i] = f.v_D;
            const double slope = round == 0 ? 0 : -fit.x[0] * std::sin(f.x) + fit.x[1] * std::cos(f.x);
            sigma[i] = std::hypot(f.sigma, slope * f.x_sigma);
        }
        fit = least_squares(A, y, sigma, Weights::equal);
    }
    const double c = fit.x[0], s = fit.x[1], v = std::hypot(c, s);
    Eigen::Matrix2d to;  // d(v, theta) / d(c, s)
    to << c / v, s / v, -s / (v * v), c / (v * v);
    // What the cosine misses acts on it as another choice of the phases would.
    const Eigen::Matrix2d missed =
        fit.residuals.squaredNorm() / static_cast<double>(n - 2) * fit.gain * fit.gain.transpose();
    const Eigen::Matrix2d cov = to * (fit.covariance + missed) * to.transpose();
    CosineFit out;
    out.rms = std::sqrt(fit.residuals.squaredNorm() / static_cast<double>(n));
    const std::string note =
        misfit(fit.chi2, fit.freedom,
               fmt::format("v_D(phi) is not a cosine, rms residual {:.2g} mm/s, {:.2g} % of v_D*",
                           1e3 * out.rms, 100 * out.rms / v));
    out.amplitude = {.name = "v_D*",
                     .value = v,
                     .error = std::sqrt(cov(0, 0)),
                     .unit = "m/s",
                     .chi2 = fit.chi2,
                     .freedom = fit.freedom,
                     .points = static_cast<int>(n),
                     .note = note,
                     .gamma = gamma,
                     .series = series};
    out.theta = out.amplitude;
    out.theta.name = "Theta*";
    out.theta.value = std::atan2(s, c);
    out.theta.error = std::sqrt(cov(1, 1));
    out.theta.unit = "rad";
    out.theta.note.clear();
    out.covariance = {{"v_D*", "Theta*"}, {cov(0, 0), cov(0, 1), cov(1, 0), cov(1, 1)}};
    return out;
}

// The points of a group continued over two turns, -v_D at phi + pi.
std::vector<Folded> continued(const std::vector<Folded>& group) {
    std::vector<Folded> out;
    for (int k = -1; k <= 2; ++k)
        for (Folded f : group) {
            f.x += k * pi;
            if (k % 2 != 0) f.v_D = -f.v_D;
            out.push_back(f);
        }
    return out;
}

// Root of sum x_k t^k nearest to t = 0.
double root_near_0(const Eigen::VectorXd& x) {
    double t = 0;
    for (int i = 0; i < 50; ++i) {
        double value = 0, slope = 0;
        for (Eigen::Index k = x.size() - 1; k >= 0; --k) {
            slope = slope * t + value;
            value = value * t + x[k];
        }
        t -= std::clamp(value / slope, -0.1, 0.1);
    }
    return t;
}

std::optional<Fit> null_phase(const std::vector<Folded>& group, double gamma) {
    const std::vector<Folded> all = continued(group), phases = merged(all, same_phase);
    double guess = NAN;
    for (std::size_t i = 1; i < phases.size(); ++i) {
        const Folded &a = phases[i - 1], &b = phases[i];
        const double at = a.x + (b.x - a.x) * a.v_D / (a.v_D - b.v_D);
        if (a.v_D > 0 && b.v_D <= 0 && at >= 0 && at < two_pi && at - a.x < near_null && b.x - at < near_null)
            guess = at;
    }
    if (std::isnan(guess)) return std::nullopt;
    std::vector<Folded> used;  // mirror partners have equal weight, so a tilt cancels
    int count = 0;
    for (const Folded& f : phases)
        if (std::abs(f.x - guess) <= near_null) used.push_back(f);
    for (const Folded& f : all) count += std::abs(f.x - guess) <= near_null;
    const auto terms = static_cast<Eigen::Index>(std::min<std::size_t>(used.size(), 4));
    const auto n = static_cast<Eigen::Index>(used.size());
    Eigen::MatrixXd A(n, terms);
    Eigen::VectorXd y(n), sigma(n);
    double slope = 0;
    Linear fit;
    for (int round = 0; round < 2; ++round) {
        for (Eigen::Index i = 0; i < n; ++i) {
            const Folded& f = used[static_cast<std::size_t>(i)];
            for (Eigen::Index k = 0; k < terms; ++k) A(i, k) = std::pow(f.x - guess, static_cast<double>(k));
            y[i] = f.v_D;
            sigma[i] = std::hypot(f.sigma, slope * f.x_sigma);
        }
        fit = least_squares(A, y, sigma, Weights::by_error);
        slope = fit.x[1];
    }
    const double t = root_near_0(fit.x);
    Eigen::VectorXd powers(terms);
    slope = 0;
    for (Eigen::Index k = 0; k < terms; ++k) {
        powers[k] = std::pow(t, static_cast<double>(k));
        if (k > 0) slope += static_cast<double>(k) * fit.x[k] * std::pow(t, static_cast<double>(k - 1));
    }
    const double variance = powers.dot(fit.covariance * powers) / (slope * slope);
    return Fit{.name = "phi_0",
               .value = guess + t,
               .error = std::hypot(std::sqrt(variance), terms == 2 ? line_bias : 0.0),
               .unit = "rad",
               .chi2 = fit.chi2,
               .freedom = fit.freedom,
               .points = count,
               .note = misfit(fit.chi2, fit.freedom, "v_D around the null is not a cubic"),
               .gamma = gamma};
}

}  // namespace

double phi_error(const Point& p) noexcept { return std::hypot(phase_noise(p), p.turn_sd, p.turn_told); }

std::vector<CosineFit> cosine_fits(std::span<const Point> points) {
    std::vector<CosineFit> fits;
    for (const auto& [gamma, group] : by_gamma(points)) {
        std::map<std::pair<int, std::string>, std::vector<Folded>> series;
        for (const Folded& f : group) series[{f.point->campaign, f.point->series}].push_back(f);
        for (const auto& [name, part] : series)
            if (merged(part, same_phase).size() >= 3 && gaps_hold(part))
                fits.push_back(cosine_fit(part, gamma, name.second));
    }
    return fits;
}

std::vector<Fit> null_phases(std::span<const Point> points) {
    std::vector<Fit> fits;
    for (const auto& [gamma, group] : by_gamma(points))
        if (auto fit = null_phase(group, gamma)) fits.push_back(std::move(*fit));
    return fits;
}

}  // namespace shaker::law
