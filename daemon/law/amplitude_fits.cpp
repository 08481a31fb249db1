// Fits of v_D against gamma.
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "daemon/law/phase_fits.hpp"
#include "daemon/law/point.hpp"
#include "daemon/law/pushed_walker.hpp"
#include "drivers/trig_polynomial.hpp"

namespace shaker::law {

namespace {

constexpr double same_gamma = 5e-3;  // of gamma: one set-point, measured twice
constexpr double line_misses = 0.1;  // of the distance of two points: possible curvature
constexpr double at_rest = 4;        // errors of v_D

// Polynomial through points first..last at x; weights: of each v_D in it.
double through(std::span<const Folded> points, double x, std::vector<double>* weights = nullptr) {
    double sum = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        double w = 1;
        for (std::size_t k = 0; k < points.size(); ++k)
            if (k != i) w *= (x - points[k].x) / (points[i].x - points[k].x);
        sum += w * points[i].v_D;
        if (weights != nullptr) weights->push_back(w);
    }
    return sum;
}

double root_between(std::span<const Folded> points, double a, double b) {
    const bool positive = through(points, a) > 0;
    for (int i = 0; i < 100; ++i) {
        const double mid = (a + b) / 2;
        ((through(points, mid) > 0) == positive ? a : b) = mid;
    }
    return (a + b) / 2;
}

Fit reversal_of(const Folded& after, double at, double variance, std::size_t points) {
    return {.name = "gamma of reversal",
            .value = at,
            .error = std::sqrt(variance),
            .unit = "m/s^2",
            .points = static_cast<int>(points),
            .note = after.v_D < 0 ? "v_D becomes negative at larger gamma"
                                  : "v_D becomes positive at larger gamma"};
}

Fit by_polynomial(const std::vector<Folded>& v, std::size_t before) {
    const std::size_t after = before + 1;
    const std::size_t first = before > 0 ? before - 1 : before, last = std::min(after + 1, v.size() - 1);
    const std::span<const Folded> all{v.data() + first, last - first + 1},
        fewer{v.data() + before, std::min<std::size_t>(last - before, 2) + 1}, two{v.data() + before, 2};
    const double a = v[before].x, b = v[after].x, at = root_between(all, a, b);
    double off = line_misses * (b - a);
    if (all.size() > 2) off = at - root_between(all.size() == fewer.size() ? two : fewer, a, b);
    std::vector<double> weights;
    through(all, at, &weights);
    const double step = 1e-4 * at, slope = (through(all, at + step) - through(all, at - step)) / (2 * step);
    double variance = off * off;
    for (std::size_t i = 0; i < all.size(); ++i) variance += std::pow(weights[i] * all[i].sigma / slope, 2);
    return reversal_of(v[after], at, variance, all.size());
}

// Law plus the distance of the points from it, which changes little and linearly between them.
Fit by_law(const Folded& a, const Folded& b, double phi, const Coulomb& law) {
    const double frequency = a.point->asked.frequency;
    const auto predicted = [&](double gamma) {
        return pushed_cycle(harmonics({.frequency = frequency, .gamma = gamma, .phi = phi}), frequency,
                            {.mu = law.mu, .g = law.g})
            .v_D;
    };
    const double off_a = a.v_D - predicted(a.x), off_b = b.v_D - predicted(b.x);
    const auto v_D = [&](double gamma) {
        return predicted(gamma) + off_a + (off_b - off_a) * (gamma - a.x) / (b.x - a.x);
    };
    double low = a.x, high = b.x;
    for (int i = 0; i < 40; ++i) {
        const double mid = (low + high) / 2;
        ((v_D(mid) > 0) == (a.v_D > 0) ? low : high) = mid;
    }
    const double at = (low + high) / 2, share = (at - a.x) / (b.x - a.x), step = 1e-4 * at;
    const double slope = (v_D(at + step) - v_D(at - step)) / (2 * step);
    const double noise = std::hypot((1 - share) * a.sigma, share * b.sigma);
    const double bend = share * (1 - share) * (off_b - off_a);
    return reversal_of(b, at, (noise * noise + bend * bend) / (slope * slope), 2);
}

bool rests(const Point& p) {
    const bool whole = p.stick.size() == 1 && p.stick[0].to - p.stick[0].from >= 1 - 1e-9;
    return whole && std::abs(p.v_D.value) < at_rest * p.v_D.sigma;
}

// max |a_B| over a period, of the asked drive with gamma = 1.
double peak(const Drive& drive) {
    Drive unit = drive;
    unit.gamma = 1;
    const TrigPolynomial a{0, harmonics(unit).a};
    double most = std::abs(a(0.0));
    for (const double phase : sign_changes(a.derivative())) most = std::max(most, std::abs(a(phase)));
    return most;
}

}  // namespace

std::vector<Fit> reversals(std::span<const Point> points, const Coulomb* law) {
    std::vector<Fit> fits;
    for (const auto& [phi, group] : by_phi(points)) {
        const std::vector<Folded> v = merged(group, 0, same_gamma);
        for (std::size_t i = 1; i < v.size(); ++i) {
            const bool clear = std::abs(v[i - 1].v_D) > at_rest * v[i - 1].sigma;
            if (!clear || (v[i - 1].v_D > 0) == (v[i].v_D > 0)) continue;
            fits.push_back(law != nullptr ? by_law(v[i - 1], v[i], phi, *law) : by_polynomial(v, i - 1));
            fits.back().phi = phi;
        }
    }
    return fits;
}

std::vector<Fit> thresholds(std::span<const Point> points, double g) {
    std::vector<Fit> fits;
    Fit none{.name = "threshold", .unit = "m/s^2"};
    double least = 1e300;
    for (const auto& [phi, group] : by_phi(points)) {
        double rest = 0, motion = 1e300;
        for (const Folded& f : group)
            if (rests(*f.point)) rest = std::max(rest, f.x);
        for (const Folded& f : group)
            if (!rests(*f.point) && f.x > rest) motion = std::min(motion, f.x);
        least = std::min(least, group.front().x);
        if (rest == 0 || motion > 1e299) continue;
        Fit fit = none;
        fit.value = (rest + motion) / 2;
        fit.error = (motion - rest) / 2 / std::numbers::sqrt3;
        fit.points = static_cast<int>(group.size());
        fit.phi = phi;
        const double most = peak(group.front().point->asked);
        fit.note = fmt::format("at rest at {}, in motion at {}: mu_s = {:.4f} +- {:.4f}", in_g(rest),
                               in_g(motion), most * fit.value / g, most * fit.error / g);
        fits.push_back(std::move(fit));
    }
    if (!fits.empty()) return fits;
    none.points = static_cast<int>(points.size());
    none.note =
        points.empty()
            ? "no points"
            : fmt::format("no phase has points at rest and in motion; the lowest gamma is {}", in_g(least));
    return {none};
}

}  // namespace shaker::law
