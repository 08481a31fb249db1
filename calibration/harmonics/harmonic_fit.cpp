#include "calibration/harmonics/harmonic_fit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "calibration/harmonics/harmonic_model.hpp"
#include "calibration/harmonics/harmonic_sums.hpp"
#include "calibration/harmonics/phasors.hpp"
#include "drivers/drive.hpp"

namespace shaker::calibration {
namespace {

/// Fraction of a turn, -1/2..1/2. std::remainder is exact too but ten times slower.
double fraction(double turns) { return turns - std::rint(turns); }

/// The samples of each stream within `half_width` of `centre`.
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

/// Sums over all streams; each stream has its own constant. The derivative's column is the last.
NormalEquations sums_of(std::span<const HarmonicSamples> streams, const HarmonicModel& m,
                        const std::vector<std::vector<int>>& columns) {
    const Eigen::Index n = m.columns() + static_cast<int>(streams.size()) - 1;
    NormalEquations out{Eigen::MatrixXd::Zero(n, n), Eigen::MatrixXd::Zero(n, 1)};
    for (std::size_t k = 0; k < streams.size(); ++k) {
        const HarmonicSamples& s = streams[k];
        const NormalEquations one = normal_equations(m, s.t, s.sd, {&s.y, 1});
        out.normal(columns[k], columns[k]) += one.normal;
        out.right(columns[k], 0) += one.right;
    }
    return out;
}

/// Positions of the columns of each stream's model among all unknowns.
std::vector<std::vector<int>> columns_of(const HarmonicModel& m, std::size_t streams) {
    std::vector<std::vector<int>> out(streams);
    for (std::size_t k = 0; k < streams; ++k) {
        for (int i = 0; i < m.constant_column(); ++i) out[k].push_back(i);
        out[k].push_back(m.constant_column() + static_cast<int>(k));
        if (!m.derivative_of.empty()) out[k].push_back(m.constant_column() + static_cast<int>(streams));
    }
    return out;
}

Estimate refine_in(std::span<const HarmonicSamples> streams, double frequency, int order) {
    constexpr double slight = 1e-6;  // relative step of frequency that hardly changes the amplitudes
    const double start = frequency;
    double sigma = std::numeric_limits<double>::quiet_NaN();
    std::size_t samples = 0;
    for (const auto& s : streams) samples += s.t.size();
    HarmonicModel m = model_of(streams, frequency, order, Slope::none);
    std::vector<std::complex<double>> a;
    for (int iteration = 0; iteration < 8; ++iteration) {
        m.frequency_hz = frequency;
        m.derivative_of = {};
        if (a.empty())
            a = amplitudes(solve(m, sums_of(streams, m, columns_of(m, streams.size())), samples).p, order);
        m.derivative_of = a;
        const auto columns = columns_of(m, streams.size());
        const Solution s = solve(m, sums_of(streams, m, columns), samples);
        const Eigen::Index last = s.p.rows() - 1;
        const double step = s.p(last);
        frequency += step;
        if (!std::isfinite(frequency) || std::abs(frequency / start - 1) > 0.05) break;
        if (std::abs(step) < 1e-10 * frequency || iteration == 7) {
            double chi2 = 0;
            for (std::size_t k = 0; k < streams.size(); ++k) {
                const HarmonicSamples& in = streams[k];
                chi2 += remainders(m, in.t, in.sd, {&in.y, 1}, s.p(columns[k], Eigen::all)).front().chi2;
            }
            const auto freedom = static_cast<double>(samples) - static_cast<double>(s.p.rows());
            sigma = std::sqrt(s.inverse(last, last) * chi2 / freedom);
            break;
        }
        if (std::abs(step) > slight * frequency)
            a.clear();
        else
            a = amplitudes(s.p, order);
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

SHAKER_WIDE void HarmonicFit::periodic(std::span<const double> t_s, std::span<double> out) const noexcept {
    constexpr std::size_t block = Phasors::size;
    for (std::size_t begin = 0; begin < t_s.size(); begin += block) {
        const std::size_t count = std::min(block, t_s.size() - begin);
        std::array<double, block> turns{};
        for (std::size_t i = 0; i < count; ++i) turns[i] = frequency_hz * (t_s[begin + i] - origin_s);
        std::copy_n(polynomial(a, phasors(turns)).im.begin(), count,
                    out.begin() + static_cast<std::ptrdiff_t>(begin));
    }
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
    return HarmonicSums(streams, frequency_hz, order, slope).fit(order);
}

std::vector<HarmonicFit> fit_signals(std::span<const double> t,
                                     std::span<const std::span<const double>> signals, double frequency_hz,
                                     int order) {
    const HarmonicSamples times{t, {}, {}};
    const HarmonicModel m = model_of({&times, 1}, frequency_hz, order, Slope::none);
    const Solution solved = solve(m, normal_equations(m, t, {}, signals), t.size());
    const std::vector<Remainder> left = remainders(m, t, {}, signals, solved.p);
    std::vector<HarmonicFit> out(signals.size());
    for (std::size_t i = 0; i < out.size(); ++i) {
        out[i].samples = t.size();
        out[i].stream_rms = {std::sqrt(left[i].chi2 / static_cast<double>(t.size()))};
        set_solution(out[i], m, solved, static_cast<Eigen::Index>(i), left[i]);
    }
    return out;
}

Estimate refine_frequency(std::span<const HarmonicSamples> streams, double near_hz, int order) {
    return refine_frequency(streams, Estimate{near_hz, std::numeric_limits<double>::infinity()}, order);
}

Estimate refine_frequency(std::span<const HarmonicSamples> streams, const Estimate& near, int order) {
    // An error below this part of a turn at the ends of a window is safe for Gauss-Newton.
    constexpr double safe_turns = 0.01;
    const HarmonicModel all = model_of(streams, near.value, order, Slope::none);
    double low = all.origin_s, high = all.origin_s;
    for (const auto& s : streams) {
        if (s.t.empty()) continue;
        low = std::min(low, s.t.front());
        high = std::max(high, s.t.back());
    }
    const double reach = std::max(all.origin_s - low, high - all.origin_s);
    const double known = safe_turns / (order * 4 * near.sigma);
    double frequency = near.value;
    for (double half = 4 / near.value; half < reach; half *= 4) {
        if (4 * half < known) continue;
        const auto part = window(streams, all.origin_s, half);
        std::size_t samples = 0;
        for (const auto& s : part) samples += s.t.size();
        if (samples < 4 * (static_cast<std::size_t>(all.constant_column()) + part.size() + 1)) continue;
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

}  // namespace shaker::calibration
