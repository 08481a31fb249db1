#include "daemon/reduction/combined_drift.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "daemon/reduction/drift_spread.hpp"
#include "drivers/drive.hpp"

namespace shaker::reduction {

namespace {

using calibration::Estimate;

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
