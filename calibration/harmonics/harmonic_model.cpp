#include "calibration/harmonics/harmonic_model.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "calibration/harmonics/power_sums.hpp"
#include "drivers/errors.hpp"

namespace shaker::calibration {
namespace {

void require_solvable(const HarmonicModel& m, Eigen::Index unknowns, std::size_t samples,
                      double reciprocal_condition) {
    if (samples <= static_cast<std::size_t>(unknowns)) {
        throw InputError("harmonic fit: " + std::to_string(samples) + " samples for " +
                         std::to_string(unknowns) + " unknowns (harmonics up to " + std::to_string(m.order) +
                         "); more samples are required");
    }
    if (!(reciprocal_condition > 1e-11)) {
        throw InputError("harmonic fit: the sample times do not separate " + std::to_string(m.order) +
                         " harmonics of " + std::to_string(m.frequency_hz) +
                         " Hz; use more or more evenly spaced samples");
    }
}

}  // namespace

TimeWeight time_weight(const HarmonicSamples& s) {
    TimeWeight out;
    for (std::size_t i = 0; i < s.t.size(); ++i) {
        const double w = s.sd.empty() ? 1.0 : 1 / (s.sd[i] * s.sd[i]);
        out.weight += w;
        out.weighted_t += w * s.t[i];
    }
    return out;
}

HarmonicModel model_of(std::span<const HarmonicSamples> streams, double frequency_hz, int order,
                       Slope slope) {
    TimeWeight all;
    double low = 1e300, high = -1e300;
    for (const auto& s : streams) {
        const TimeWeight w = time_weight(s);
        all.weight += w.weight;
        all.weighted_t += w.weighted_t;
        if (s.t.empty()) continue;
        low = std::min(low, s.t.front());
        high = std::max(high, s.t.back());
    }
    HarmonicModel m;
    m.frequency_hz = frequency_hz;
    m.origin_s = all.weight > 0 ? all.weighted_t / all.weight : 0.0;
    m.half_span_s = std::max((high - low) / 2, 1e-9);
    m.order = order;
    m.slope = slope;
    return m;
}

NormalEquations normal_equations(const HarmonicModel& model, std::span<const double> t,
                                 std::span<const double> sd,
                                 std::span<const std::span<const double>> signals) {
    Blocks blocks(model, t, sd, signals);
    PowerSums sums(model, signals.size());
    while (const SampleBlock* s = blocks.next()) sums.add(*s);
    return sums.equations(model);
}

std::vector<Remainder> remainders(const HarmonicModel& model, std::span<const double> t,
                                  std::span<const double> sd,
                                  std::span<const std::span<const double>> signals,
                                  const Eigen::MatrixXd& parameters) {
    std::vector<Remainder> out(signals.size());
    std::vector<std::vector<std::complex<double>>> a;
    for (Eigen::Index s = 0; s < parameters.cols(); ++s)
        a.push_back(amplitudes(parameters.col(s), model.order));
    Blocks blocks(model, t, sd, signals);
    const Eigen::Index slope = model.constant_column() - 1;
    while (const SampleBlock* s = blocks.next()) {
        for (std::size_t k = 0; k < out.size(); ++k) {
            const auto p = parameters.col(static_cast<Eigen::Index>(k));
            BlockColumn left = polynomial(a[k], s->z).im;
            const double constant = p(model.constant_column());
            for (std::size_t i = 0; i < left.size(); ++i) left[i] = s->values[k][i] - left[i] - constant;
            if (model.slope == Slope::free)
                for (std::size_t i = 0; i < left.size(); ++i) left[i] -= p(slope) * s->others.front()[i];
            if (!model.derivative_of.empty())
                for (std::size_t i = 0; i < left.size(); ++i)
                    left[i] -= p(p.size() - 1) * s->others.back()[i];
            std::fill(left.begin() + static_cast<std::ptrdiff_t>(s->count), left.end(), 0.0);
            out[k].squares += dot(left, left);
            BlockColumn weighted;
            for (std::size_t i = 0; i < left.size(); ++i) weighted[i] = s->weight[i] * left[i];
            out[k].chi2 += dot(weighted, left);
        }
    }
    return out;
}

Solution solve(const HarmonicModel& model, const NormalEquations& sums, std::size_t samples) {
    const Eigen::Index n = sums.normal.rows();
    // Columns differ in size, the derivative's most: scales them before the decomposition.
    const Eigen::VectorXd d = sums.normal.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    const Eigen::MatrixXd normal = sums.normal.selfadjointView<Eigen::Lower>();
    const Eigen::MatrixXd scaled = d.asDiagonal() * normal * d.asDiagonal();
    const Eigen::LLT<Eigen::MatrixXd> llt(scaled);
    require_solvable(model, n, samples, llt.info() == Eigen::Success ? llt.rcond() : 0.0);
    return {d.asDiagonal() * llt.solve(d.asDiagonal() * sums.right),
            d.asDiagonal() * llt.solve(Eigen::MatrixXd::Identity(n, n)) * d.asDiagonal()};
}

void set_solution(HarmonicFit& fit, const HarmonicModel& m, const Solution& solved, Eigen::Index signal,
                  const Remainder& left) {
    const auto p = solved.p.col(signal);
    fit.frequency_hz = m.frequency_hz;
    fit.origin_s = m.origin_s;
    fit.a = amplitudes(p, m.order);
    const double freedom = static_cast<double>(fit.samples) - static_cast<double>(p.size());
    const double variance = left.chi2 / freedom;
    fit.scale = std::sqrt(variance);
    fit.rms = std::sqrt(left.squares / freedom);
    for (int i = 0; i < 2 * m.order; ++i) {
        for (int j = 0; j < 2 * m.order; ++j) fit.covariance.push_back(variance * solved.inverse(i, j));
    }
    fit.slope = {0, 0};
    if (m.slope == Slope::free) {
        const Eigen::Index k = m.constant_column() - 1;
        fit.slope = {p(k) / m.half_span_s, std::sqrt(variance * solved.inverse(k, k)) / m.half_span_s};
    }
    for (Eigen::Index i = m.constant_column(); i < p.size(); ++i) fit.constants.push_back(p(i));
}

std::vector<std::complex<double>> amplitudes(const Eigen::VectorXd& p, int order) {
    std::vector<std::complex<double>> a;
    for (Eigen::Index q = 0; q < order; ++q) a.emplace_back(p(2 * q), p(2 * q + 1));
    return a;
}

}  // namespace shaker::calibration
