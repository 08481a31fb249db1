#include "tracking/image/bar_fit.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace shaker::tracking {
namespace {

constexpr double reach_sigmas = 5;
constexpr double least_blur = 0.2, most_blur = 6;

double distribution(double t) { return 0.5 * std::erfc(-t / std::numbers::sqrt2); }
double density(double t) { return std::exp(-0.5 * t * t) / std::sqrt(2 * std::numbers::pi); }

/// One edge of height 1, seen by a pixel at `x` from it.
struct EdgeShare {
    double step, slope, by_blur;
    EdgeShare(double x, double blur) {
        const double a = (x + 0.5) / blur, b = (x - 0.5) / blur;
        const double at_a = distribution(a), at_b = distribution(b);
        by_blur = density(a) - density(b);
        slope = at_a - at_b;
        step = blur * (a * at_a - b * at_b + by_blur);  // the integral of Phi is t Phi + phi
    }
};

/// Edges that are neither all before nor all behind the pixel.
std::pair<std::size_t, std::size_t> near(const BarModel& m, double x) {
    const double reach = reach_sigmas * m.blur + 0.5;
    const auto first = std::ranges::lower_bound(m.edges, x - reach);
    const auto last = std::upper_bound(first, m.edges.end(), x + reach);
    return {static_cast<std::size_t>(first - m.edges.begin()),
            static_cast<std::size_t>(last - m.edges.begin())};
}

// Crossings of the middle with hysteresis; levels are means between the edges.
BarModel first_guess(std::span<const double> profile) {
    const auto n = static_cast<std::ptrdiff_t>(profile.size());
    const auto around = std::max<std::ptrdiff_t>(24, n / 8);
    const auto [lowest, highest] = std::ranges::minmax(profile);
    BarModel m;
    int side = 0;
    double before = 0;  // profile minus middle at the pixel before
    double crossed = 0;
    for (std::ptrdiff_t i = 0; i < n; ++i) {
        const auto local = profile.subspan(
            static_cast<std::size_t>(std::max<std::ptrdiff_t>(0, i - around)),
            static_cast<std::size_t>(std::min(n, i + around + 1) - std::max<std::ptrdiff_t>(0, i - around)));
        const auto [low, high] = std::ranges::minmax(local);
        const double here = profile[static_cast<std::size_t>(i)] - 0.5 * (low + high);
        if (i > 0 && (here > 0) != (before > 0)) crossed = static_cast<double>(i) - here / (here - before);
        before = here;
        if (high - low < 0.3 * (highest - lowest) || std::abs(here) < 0.2 * (high - low)) continue;
        const int now = here > 0 ? 1 : -1;
        if (side != 0 && now != side) m.edges.push_back(crossed);
        side = now;
    }
    for (std::size_t k = 0; k <= m.edges.size(); ++k) {
        const double from = k == 0 ? 0 : m.edges[k - 1];
        const double to = k == m.edges.size() ? static_cast<double>(n - 1) : m.edges[k];
        m.levels.push_back(profile[static_cast<std::size_t>(0.5 * (from + to))]);
    }
    return m;
}

/// Normal equations of the parameters: edges, levels, blur.
struct Normal {
    Eigen::MatrixXd a;
    Eigen::VectorXd b;
    double squares = 0;
};

Normal normal_equations(const BarModel& m, std::span<const double> profile) {
    const std::size_t edges = m.edges.size(), size = 2 * edges + 2;
    const auto wide = static_cast<Eigen::Index>(size);
    Normal normal{Eigen::MatrixXd::Zero(wide, wide), Eigen::VectorXd::Zero(wide)};
    std::vector<std::pair<Eigen::Index, double>> row;
    for (std::size_t i = 0; i < profile.size(); ++i) {
        const double x = static_cast<double>(i);
        const auto [first, last] = near(m, x);
        double value = m.levels[first], by_blur = 0, share = 1;
        row.clear();
        for (std::size_t k = first; k < last; ++k) {
            const EdgeShare e{x - m.edges[k], m.blur};
            const double height = m.levels[k + 1] - m.levels[k];
            value += height * e.step;
            by_blur += height * e.by_blur;
            row.emplace_back(static_cast<Eigen::Index>(k), -height * e.slope);
            row.emplace_back(static_cast<Eigen::Index>(edges + k), share - e.step);
            share = e.step;
        }
        row.emplace_back(static_cast<Eigen::Index>(edges + last), share);
        row.emplace_back(wide - 1, by_blur);
        const double off = profile[i] - value;
        normal.squares += off * off;
        for (const auto& [r, u] : row) {
            normal.b(r) += u * off;
            for (const auto& [c, v] : row) normal.a(r, c) += u * v;
        }
    }
    return normal;
}

}  // namespace

BarModel::Value BarModel::at(double x) const noexcept {
    const auto [first, last] = near(*this, x);
    Value value{levels[first], 0, 0};
    for (std::size_t k = first; k < last; ++k) {
        const EdgeShare e{x - edges[k], blur};
        value.level += (levels[k + 1] - levels[k]) * e.step;
        value.slope += (levels[k + 1] - levels[k]) * e.slope;
        value.by_blur += (levels[k + 1] - levels[k]) * e.by_blur;
    }
    return value;
}

double BarModel::narrowest() const noexcept {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t k = 1; k < edges.size(); ++k) least = std::min(least, edges[k] - edges[k - 1]);
    return least;
}

BarModel fit_bars(std::span<const double> profile) {
    constexpr int passes = 12;
    BarModel m = first_guess(profile);
    if (m.edges.empty() || 4 * m.edges.size() > profile.size()) return m;
    double mean = 0, variance = 0;
    for (const double v : profile) mean += v / static_cast<double>(profile.size());
    for (const double v : profile) variance += (v - mean) * (v - mean);
    for (int pass = 0; pass < passes; ++pass) {
        Normal normal = normal_equations(m, profile);
        m.explained = variance > 0 ? 1 - normal.squares / variance : 0;
        normal.a.diagonal().array() += 1e-9 * normal.a.diagonal().maxCoeff();
        const Eigen::VectorXd step = normal.a.ldlt().solve(normal.b);
        if (!step.allFinite()) return {};
        const std::size_t edges = m.edges.size();
        for (std::size_t k = 0; k < edges; ++k)
            m.edges[k] += std::clamp(step(static_cast<Eigen::Index>(k)), -0.5, 0.5);
        for (std::size_t k = 0; k <= edges; ++k) m.levels[k] += step(static_cast<Eigen::Index>(edges + k));
        m.blur = std::clamp(m.blur + std::clamp(step(step.size() - 1), -0.3, 0.3), least_blur, most_blur);
        if (!std::ranges::is_sorted(m.edges)) return {};
    }
    return m;
}

}  // namespace shaker::tracking
