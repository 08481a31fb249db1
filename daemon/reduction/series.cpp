#include "daemon/reduction/series.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "daemon/reduction/spread/drift_spread.hpp"

namespace shaker::reduction {

namespace {

using calibration::Estimate;

constexpr double same_phase = 1e-6;  // rad: phases closer than this count as equal
// A second harmonic of v_D(phi) of 5 % moves the null by this much for the widest bracket; the effect falls
// with the square of the bracket.
constexpr double bend = 1e-3;  // rad

bool alike(const Drive& a, const Drive& b) {
    return a.frequency == b.frequency && a.gamma == b.gamma && a.rho == b.rho && a.biharmonic() &&
           b.biharmonic();
}

// a - b, wrapped to -pi..pi.
double between(double a, double b) { return std::remainder(a - b, two_pi); }

NullPhase null_between(const DrivenPoint& a, const DrivenPoint& b) {
    const double width = between(b.phi.value, a.phi.value);
    const double rise = b.v_D.value - a.v_D.value;
    const double share = -a.v_D.value / rise;  // share of the way from a to b
    NullPhase null;
    null.phi0.value = std::remainder(a.phi.value + share * width, two_pi);
    const double slope = std::abs(rise / width);
    null.phi0.sigma = std::hypot((1 - share) * a.v_D.sigma / slope, share * b.v_D.sigma / slope,
                                 std::hypot((1 - share) * a.phi.sigma, share * b.phi.sigma,
                                            bend * width * width / (widest_bracket * widest_bracket)));
    null.theta = {null.phi0.value - std::numbers::pi / 2, null.phi0.sigma};
    return null;
}

constexpr double shared_freedom = 20;  // weight of what the passes have in common
constexpr double least_error = 1e-15;  // m/s; a pass without noise still has rounding errors

struct Pass {
    double v, variance, freedom, periods;
};

// Exponent p of variance = c n^-p, by a straight line through the logarithms.
double exponent(const std::vector<Pass>& passes) {
    double mean_x = 0, mean_y = 0, xx = 0, xy = 0;
    const auto k = static_cast<double>(passes.size());
    for (const Pass& p : passes) {
        mean_x += std::log(p.periods) / k;
        mean_y += std::log(p.variance) / k;
    }
    for (const Pass& p : passes) {
        const double dx = std::log(p.periods) - mean_x;
        xx += dx * dx;
        xy += dx * (std::log(p.variance) - mean_y);
    }
    return xx > 1e-9 ? std::clamp(-xy / xx, 1.0, 3.0) : 1.0;
}

// Weights 1 / S_i^2.
std::vector<double> weights_of(const std::vector<Pass>& passes) {
    const double p = exponent(passes);
    double log_c = 0, freedom = 0;
    for (const Pass& pass : passes) {  // a logarithm's mean is low by about 1 / freedom
        log_c += pass.freedom * std::log(pass.variance * std::pow(pass.periods, p)) + 1;
        freedom += pass.freedom;
    }
    const double c = std::exp(log_c / freedom);
    std::vector<double> weights;
    for (const Pass& pass : passes)
        weights.push_back((pass.freedom + shared_freedom) /
                          (pass.freedom * pass.variance + shared_freedom * c * std::pow(pass.periods, -p)));
    return weights;
}

}  // namespace

bool mirrored(const Drive& a, const Drive& b) {
    return alike(a, b) && std::abs(std::abs(between(a.phi, b.phi)) - std::numbers::pi) <= same_phase;
}

std::optional<MirrorPair> mirror_pair(std::span<const DrivenPoint> points) {
    if (points.empty()) return std::nullopt;
    const DrivenPoint& a = points.back();
    for (std::size_t i = points.size() - 1; i-- > 0;) {
        const DrivenPoint& b = points[i];
        if (!mirrored(a.asked, b.asked)) continue;
        const double sigma = std::hypot(a.v_D.sigma, b.v_D.sigma) / 2;
        return MirrorPair{{(a.v_D.value - b.v_D.value) / 2, sigma}, {(a.v_D.value + b.v_D.value) / 2, sigma}};
    }
    return std::nullopt;
}

std::optional<NullPhase> null_phase(std::span<const DrivenPoint> points) {
    if (points.empty()) return std::nullopt;
    const DrivenPoint& a = points.back();
    const DrivenPoint* nearest = nullptr;
    const auto width = [&](const DrivenPoint& p) { return between(p.phi.value, a.phi.value); };
    if (a.asked.rho != 0.5) return std::nullopt;
    for (const DrivenPoint& b : points.first(points.size() - 1)) {
        if (!alike(a.asked, b.asked) || std::abs(width(b)) > widest_bracket) continue;
        const bool across = (b.v_D.value - a.v_D.value) * width(b) < 0 && a.v_D.value * b.v_D.value <= 0;
        if (across && (nearest == nullptr || std::abs(width(b)) <= std::abs(width(*nearest)))) nearest = &b;
    }
    if (nearest == nullptr) return std::nullopt;
    return null_between(a, *nearest);
}

CombinedDrift combined(std::span<const PassDrift> passes) {
    CombinedDrift out;
    out.weights.assign(passes.size(), 0);
    if (passes.size() == 1) return {passes[0].v_D, {1}};
    std::vector<Pass> usable;
    std::vector<std::size_t> which;
    for (std::size_t i = 0; i < passes.size(); ++i) {
        const Estimate& v_D = passes[i].v_D;
        if (!std::isfinite(v_D.value) || !std::isfinite(v_D.sigma)) continue;
        const int freedom = std::max(1, passes[i].periods - 1);
        const double s = std::max(least_error, v_D.sigma / few_periods_factor(freedom));
        usable.push_back({v_D.value, s * s, static_cast<double>(freedom), freedom + 1.0});
        which.push_back(i);
    }
    if (usable.empty()) return out;
    if (usable.size() == 1) {
        out.v_D = passes[which[0]].v_D;
        out.weights[which[0]] = 1;
        return out;
    }
    const std::vector<double> w = weights_of(usable);
    const double sum = std::accumulate(w.begin(), w.end(), 0.0);
    double v = 0, scatter = 0, freedom = 0;
    for (std::size_t i = 0; i < w.size(); ++i) {
        out.weights[which[i]] = w[i] / sum;
        v += w[i] / sum * usable[i].v;
        freedom += usable[i].freedom;
    }
    for (std::size_t i = 0; i < w.size(); ++i) scatter += w[i] * (usable[i].v - v) * (usable[i].v - v);
    out.chi2 = scatter / static_cast<double>(w.size() - 1);
    out.v_D = {v, few_periods_factor(static_cast<int>(freedom)) * std::sqrt(std::max(1.0, out.chi2) / sum)};
    return out;
}

Estimate weighted(std::span<const Estimate> values, std::span<const double> weights) {
    if (values.size() == 1) return values[0];
    double mean = 0, variance = 0, chi2 = 0;
    int used = 0;
    for (std::size_t i = 0; i < values.size(); ++i) {
        if (weights[i] == 0) continue;
        ++used;
        mean += weights[i] * values[i].value;
        variance += weights[i] * weights[i] * values[i].sigma * values[i].sigma;
    }
    if (used == 0) return {};
    for (std::size_t i = 0; i < values.size(); ++i)
        if (weights[i] > 0 && values[i].sigma > 0)
            chi2 += std::pow((values[i].value - mean) / values[i].sigma, 2) / std::max(1, used - 1);
    return {mean, std::sqrt(variance * std::max(1.0, chi2))};
}

Estimate weighted_angle(std::span<const Estimate> angles, std::span<const double> weights) {
    if (angles.size() == 1) return angles[0];
    std::vector<Estimate> differences{angles.begin(), angles.end()};
    for (Estimate& d : differences) d.value = std::remainder(d.value - angles[0].value, two_pi);
    const Estimate mean = weighted(differences, weights);
    return {std::remainder(angles[0].value + mean.value, two_pi), mean.sigma};
}

}  // namespace shaker::reduction
