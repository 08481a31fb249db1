#include "calibration/harmonic_fit.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "drivers/drive.hpp"
#include "drivers/errors.hpp"

namespace shaker {
namespace {

using Complexes = std::vector<std::complex<double>>;

struct Model {
    double frequency;
    double origin;
    double
        half_span;  // the slope's column runs over about -1..1, so that the normal equations stay well scaled
    int order;
    bool slope;
    const Complexes* derivative_of = nullptr;  // with it, a last column: the signal's derivative by frequency

    [[nodiscard]] int unknowns(std::size_t streams) const {
        return 2 * order + (slope ? 1 : 0) + static_cast<int>(streams) + (derivative_of ? 1 : 0);
    }
};

/// Turns less their whole number; std::remainder is exact too but ten times slower.
double fraction(double turns) { return turns - std::rint(turns); }

template <class Row>
void fill_row(const Model& m, double t, int stream, Row row) {
    const double dt = t - m.origin;
    const std::complex<double> z = std::polar(1.0, two_pi * fraction(m.frequency * dt));
    std::complex<double> zq = 1;
    double derivative = 0;
    for (int q = 1; q <= m.order; ++q) {
        zq *= z;
        row(2 * (q - 1)) = zq.imag();
        row(2 * (q - 1) + 1) = zq.real();
        if (m.derivative_of) {
            derivative += two_pi * q * dt * ((*m.derivative_of)[static_cast<std::size_t>(q - 1)] * zq).real();
        }
    }
    if (m.slope) row(2 * m.order) = dt / m.half_span;
    row(2 * m.order + (m.slope ? 1 : 0) + stream) = 1;
    if (m.derivative_of) row(row.size() - 1) = derivative;
}

struct Solution {
    Eigen::VectorXd p;
    Eigen::MatrixXd inverse;  // of the normal matrix
    double chi2 = 0;
    double square_sum = 0;  // of plain residuals
    std::size_t samples = 0;
};

void require_solvable(const Model& m, int unknowns, std::size_t samples, double reciprocal_condition) {
    if (samples <= static_cast<std::size_t>(unknowns)) {
        throw InputError("harmonic fit: " + std::to_string(samples) + " samples for " +
                         std::to_string(unknowns) + " unknowns (harmonics up to " + std::to_string(m.order) +
                         "); more samples are needed");
    }
    if (!(reciprocal_condition > 1e-11)) {
        throw InputError("harmonic fit: the sample times cannot tell " + std::to_string(m.order) +
                         " harmonics of " + std::to_string(m.frequency) + " Hz apart");
    }
}

double sd_of(const HarmonicSamples& s, std::size_t i) { return s.sd.empty() ? 1.0 : s.sd[i]; }

Solution solve(std::span<const HarmonicSamples> streams, const Model& m) {
    constexpr int block = 128;
    const int n = m.unknowns(streams.size());
    Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(n, n), rows(n, block);
    Eigen::VectorXd right = Eigen::VectorXd::Zero(n), values(block);
    Solution out;
    for (std::size_t s = 0; s < streams.size(); ++s) {
        const auto& in = streams[s];
        for (std::size_t begin = 0; begin < in.t.size(); begin += block) {
            const std::size_t end = std::min(begin + block, in.t.size());
            rows.setZero();
            values.setZero();
            for (std::size_t i = begin; i < end; ++i) {
                const auto k = static_cast<Eigen::Index>(i - begin);
                fill_row(m, in.t[i], static_cast<int>(s), rows.col(k));
                rows.col(k) /= sd_of(in, i);
                values(k) = in.y[i] / sd_of(in, i);
            }
            normal.selfadjointView<Eigen::Lower>().rankUpdate(rows);
            right.noalias() += rows * values;
        }
        out.samples += in.t.size();
    }
    // Columns differ in size (the derivative's most of all): scale them before the decomposition.
    const Eigen::VectorXd d = normal.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    normal = normal.selfadjointView<Eigen::Lower>();
    const Eigen::MatrixXd scaled = d.asDiagonal() * normal * d.asDiagonal();
    const Eigen::LLT<Eigen::MatrixXd> llt(scaled);
    require_solvable(m, n, out.samples, llt.info() == Eigen::Success ? llt.rcond() : 0.0);
    out.inverse = d.asDiagonal() * llt.solve(Eigen::MatrixXd::Identity(n, n)) * d.asDiagonal();
    out.p = d.asDiagonal() * llt.solve(d.asDiagonal() * right);
    return out;
}

void add_residuals(std::span<const HarmonicSamples> streams, const Model& m, Solution& s) {
    Eigen::VectorXd row = Eigen::VectorXd::Zero(s.p.size());
    for (std::size_t k = 0; k < streams.size(); ++k) {
        for (std::size_t i = 0; i < streams[k].t.size(); ++i) {
            row.setZero();
            fill_row(m, streams[k].t[i], static_cast<int>(k), row.head(row.size()));
            const double r = streams[k].y[i] - row.dot(s.p);
            s.square_sum += r * r;
            s.chi2 += r * r / (sd_of(streams[k], i) * sd_of(streams[k], i));
        }
    }
}

Model model_for(std::span<const HarmonicSamples> streams, double frequency, int order, bool slope) {
    double weight = 0, sum = 0, low = 1e300, high = -1e300;
    for (const auto& s : streams) {
        for (std::size_t i = 0; i < s.t.size(); ++i) {
            const double w = 1 / (sd_of(s, i) * sd_of(s, i));
            weight += w;
            sum += w * s.t[i];
        }
        if (!s.t.empty()) {
            low = std::min(low, s.t.front());
            high = std::max(high, s.t.back());
        }
    }
    return {frequency, weight > 0 ? sum / weight : 0.0, std::max((high - low) / 2, 1e-9), order, slope};
}

Complexes amplitudes(const Eigen::VectorXd& p, int order) {
    Complexes a;
    for (Eigen::Index q = 0; q < order; ++q) a.emplace_back(p(2 * q), p(2 * q + 1));
    return a;
}

/// The samples of each stream that lie within `half_width` of `centre`.
std::vector<HarmonicSamples> window(std::span<const HarmonicSamples> streams, double centre,
                                    double half_width) {
    std::vector<HarmonicSamples> out;
    for (const auto& s : streams) {
        const auto from = std::lower_bound(s.t.begin(), s.t.end(), centre - half_width) - s.t.begin();
        const auto to = std::upper_bound(s.t.begin(), s.t.end(), centre + half_width) - s.t.begin();
        const auto first = static_cast<std::size_t>(from), count = static_cast<std::size_t>(to - from);
        if (count > 0) {
            out.push_back({s.t.subspan(first, count), s.y.subspan(first, count),
                           s.sd.empty() ? s.sd : s.sd.subspan(first, count)});
        }
    }
    return out;
}

Estimate refine_in(std::span<const HarmonicSamples> streams, double frequency, int order) {
    const double start = frequency;
    double sigma = std::numeric_limits<double>::quiet_NaN();
    for (int iteration = 0; iteration < 8; ++iteration) {
        Model m = model_for(streams, frequency, order, false);
        const Complexes a = amplitudes(solve(streams, m).p, order);
        m.derivative_of = &a;
        Solution s = solve(streams, m);
        const double step = s.p(s.p.size() - 1);
        const double sd_of_unit_noise = std::sqrt(s.inverse(s.p.size() - 1, s.p.size() - 1));
        frequency += step;
        if (!std::isfinite(frequency) || std::abs(frequency / start - 1) > 0.05) break;
        if (std::abs(step) < 1e-10 * frequency || iteration == 7) {
            add_residuals(streams, m, s);
            const auto freedom = static_cast<double>(s.samples) - static_cast<double>(s.p.size());
            sigma = sd_of_unit_noise * std::sqrt(s.chi2 / freedom);
            break;
        }
    }
    return {frequency, sigma};
}

}  // namespace

double HarmonicFit::periodic(double t_s) const noexcept {
    const auto z = std::polar(1.0, two_pi * fraction(frequency_hz * (t_s - origin_s)));
    std::complex<double> sum = 0;
    for (auto it = a.rbegin(); it != a.rend(); ++it) sum = (sum + *it) * z;
    return sum.imag();
}

double HarmonicFit::cov(int i, int j) const {
    return covariance.at(static_cast<std::size_t>(i) * 2 * a.size() + static_cast<std::size_t>(j));
}

double HarmonicFit::amplitude_sd(int q) const {
    const int i = 2 * (q - 1);
    const std::complex<double> z = at(q);
    const double size = std::abs(z);
    if (size == 0) return std::sqrt((cov(i, i) + cov(i + 1, i + 1)) / 2);
    const double c = z.real() / size, s = z.imag() / size;
    return std::sqrt(c * c * cov(i, i) + 2 * c * s * cov(i, i + 1) + s * s * cov(i + 1, i + 1));
}

double HarmonicFit::phase_sd(int q) const {
    const int i = 2 * (q - 1);
    const std::complex<double> z = at(q);
    const double unknown = std::numbers::pi / std::sqrt(3.0), size = std::abs(z);
    if (size == 0) return unknown;
    const double c = z.real() / size, s = z.imag() / size;
    const double across = s * s * cov(i, i) - 2 * c * s * cov(i, i + 1) + c * c * cov(i + 1, i + 1);
    return std::min(unknown, std::sqrt(across) / size);
}

HarmonicFit fit_harmonics(std::span<const HarmonicSamples> streams, double frequency_hz, int order,
                          Slope slope) {
    const Model m = model_for(streams, frequency_hz, order, slope == Slope::free);
    Solution s = solve(streams, m);
    add_residuals(streams, m, s);
    HarmonicFit fit;
    fit.frequency_hz = frequency_hz;
    fit.origin_s = m.origin;
    fit.a = amplitudes(s.p, order);
    fit.samples = s.samples;
    const double freedom = static_cast<double>(s.samples) - static_cast<double>(s.p.size());
    fit.scale = std::sqrt(s.chi2 / freedom);
    fit.rms = std::sqrt(s.square_sum / freedom);
    const double variance = s.chi2 / freedom;
    for (int i = 0; i < 2 * order; ++i) {
        for (int j = 0; j < 2 * order; ++j) fit.covariance.push_back(variance * s.inverse(i, j));
    }
    const int k = 2 * order;
    fit.slope = {0, 0};
    if (m.slope) fit.slope = {s.p(k) / m.half_span, std::sqrt(variance * s.inverse(k, k)) / m.half_span};
    for (std::size_t i = 0; i < streams.size(); ++i) {
        fit.constants.push_back(s.p(k + (m.slope ? 1 : 0) + static_cast<int>(i)));
    }
    return fit;
}

Estimate refine_frequency(std::span<const HarmonicSamples> streams, double near_hz, int order) {
    const Model all = model_for(streams, near_hz, order, false);
    double low = all.origin, high = all.origin;
    for (const auto& s : streams) {
        if (s.t.empty()) continue;
        low = std::min(low, s.t.front());
        high = std::max(high, s.t.back());
    }
    const double reach = std::max(all.origin - low, high - all.origin);
    double frequency = near_hz;
    for (double half = 4 / near_hz; half < reach; half *= 4) {
        const auto part = window(streams, all.origin, half);
        std::size_t samples = 0;
        for (const auto& s : part) samples += s.t.size();
        if (samples < 4 * static_cast<std::size_t>(all.unknowns(part.size()) + 1)) continue;
        const Estimate f = refine_in(part, frequency, order);
        if (std::isfinite(f.sigma)) frequency = f.value;
    }
    return refine_in(streams, frequency, order);
}

int order_for(double samples_per_period, int most) {
    const int third = static_cast<int>(samples_per_period / 3 + 1e-6);
    return std::clamp(samples_per_period >= 5 ? std::max(third, 2) : third, 1, most);
}

double median_step(std::span<const double> t) {
    if (t.size() < 2) return 0;
    std::vector<double> steps;
    steps.reserve(t.size() - 1);
    for (std::size_t i = 1; i < t.size(); ++i) steps.push_back(t[i] - t[i - 1]);
    const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
    std::nth_element(steps.begin(), middle, steps.end());
    return *middle;
}

}  // namespace shaker
