#include "daemon/campaign/combined_passes.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numeric>

#include "daemon/reduction/drift_spread.hpp"
#include "drivers/drive.hpp"

namespace shaker::campaign {

namespace {

using calibration::Estimate;
using reduction::Cycle;
using reduction::few_periods_factor;
using reduction::MeasuredHarmonic;
using reduction::Reduction;

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

double cubic(double before, double a, double b, double after, double t) {
    return -t * (t - 1) * (t - 2) / 6 * before + (t + 1) * (t - 1) * (t - 2) / 2 * a -
           (t + 1) * t * (t - 2) / 2 * b + (t + 1) * t * (t - 1) / 6 * after;
}

double linear(double, double a, double b, double, double t) { return (1 - t) * a + t * b; }

using Interpolation = double (*)(double, double, double, double, double);

// Periodic values at equal distances, the first at phase `first`, at the phases of a points table.
std::vector<double> at_phases(const std::vector<double>& values, double first, Interpolation between) {
    const auto n = static_cast<std::int64_t>(values.size());
    const auto value = [&](std::int64_t i) { return values[static_cast<std::size_t>(((i % n) + n) % n)]; };
    std::vector<double> out;
    for (int k = 0; k < cycle_phases; ++k) {
        const double u = (static_cast<double>(k) / cycle_phases - first) * static_cast<double>(n);
        const auto i = static_cast<std::int64_t>(std::floor(u));
        out.push_back(
            between(value(i - 1), value(i), value(i + 1), value(i + 2), u - static_cast<double>(i)));
    }
    return out;
}

}  // namespace

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

MeasuredHarmonic weighted(int q, std::span<const Reduction* const> passes, std::span<const double> weights) {
    std::vector<std::complex<double>> values;
    MeasuredHarmonic out{.q = q, .amplitude = {}, .phase = {}};
    double along = 0, across = 0;  // variances
    std::complex<double> sum;
    for (std::size_t i = 0; i < passes.size(); ++i) {
        const auto h = std::ranges::find(passes[i]->harmonics, q, &MeasuredHarmonic::q);
        if (h == passes[i]->harmonics.end()) return out;
        if (passes.size() == 1) return *h;
        sum += weights[i] * std::polar(h->amplitude.value, h->phase.value);
        along += std::pow(weights[i] * h->amplitude.sigma, 2);
        across += std::pow(weights[i] * h->amplitude.value * h->phase.sigma, 2);
    }
    if (passes.empty()) return out;
    out.amplitude = {std::abs(sum), std::sqrt(along)};
    out.phase = {std::arg(sum), std::sqrt(across) / std::abs(sum)};
    return out;
}

Cycle resampled(const Cycle& cycle, double drift_per_period_m) {
    Cycle out;
    const std::size_t n = cycle.phase.size();
    if (n < 8) return out;
    const double first = cycle.phase[0];
    std::vector<double> x = cycle.x_m;
    for (std::size_t i = 0; i < n; ++i) x[i] -= drift_per_period_m * cycle.phase[i];
    out.x_m = at_phases(x, first, cubic);
    const double start = out.x_m[0];
    for (int k = 0; k < cycle_phases; ++k) {
        out.phase.push_back(static_cast<double>(k) / cycle_phases);
        double& at = out.x_m[static_cast<std::size_t>(k)];
        at += drift_per_period_m * out.phase.back() - start;
    }
    out.x_sd_m = at_phases(cycle.x_sd_m, first, linear);
    out.v_mps = at_phases(cycle.v_mps, first, cubic);
    out.v_sd_mps = at_phases(cycle.v_sd_mps, first, linear);
    out.v_base_mps = at_phases(cycle.v_base_mps, first, cubic);
    return out;
}

Cycle weighted(std::span<const Cycle> cycles, std::span<const double> weights) {
    if (cycles.size() == 1) return cycles[0];
    Cycle out;
    for (std::size_t c = 0; c < cycles.size(); ++c) {
        if (weights[c] == 0) continue;
        if (cycles[c].phase.empty()) return {};
        out.phase = cycles[c].phase;
        const auto add = [&](std::vector<double>& to, const std::vector<double>& from, bool errors) {
            to.resize(from.size());
            for (std::size_t i = 0; i < from.size(); ++i)
                to[i] = errors ? std::hypot(to[i], weights[c] * from[i]) : to[i] + weights[c] * from[i];
        };
        add(out.x_m, cycles[c].x_m, false);
        add(out.x_sd_m, cycles[c].x_sd_m, true);
        add(out.v_mps, cycles[c].v_mps, false);
        add(out.v_sd_mps, cycles[c].v_sd_mps, true);
        add(out.v_base_mps, cycles[c].v_base_mps, false);
    }
    return out;
}

}  // namespace shaker::campaign
