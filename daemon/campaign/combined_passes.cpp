#include "daemon/campaign/combined_passes.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <vector>

namespace shaker::campaign {

namespace {

using reduction::Cycle;
using reduction::MeasuredHarmonic;
using reduction::Reduction;

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
