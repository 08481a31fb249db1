#include "calibration/harmonics/harmonic_model.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <string>

#include "calibration/harmonics/phasors.hpp"
#include "drivers/drive.hpp"
#include "drivers/errors.hpp"

namespace shaker::calibration {

namespace {

/// One number per sample of a block.
using BlockColumn = std::array<double, Phasors::size>;

/// Up to one block of samples of a stream. Unused weights and values are zero.
struct SampleBlock {
    std::size_t count = 0;
    BlockColumn weight{};             // 1/sd^2
    Phasors z;                        // e^{i w (t - origin)}
    std::vector<BlockColumn> others;  // columns of slope and derivative, if the model has them
    std::vector<BlockColumn> values;  // one per signal
};

/// Iterates over a stream in blocks.
class Blocks {
public:
    Blocks(const HarmonicModel& model, std::span<const double> t, std::span<const double> sd,
           std::span<const std::span<const double>> signals);
    /// The next block; null after the last.
    SHAKER_WIDE const SampleBlock* next();

private:
    HarmonicModel m_;
    std::span<const double> t_, sd_;
    std::span<const std::span<const double>> signals_;
    std::vector<std::complex<double>> derivative_;
    std::size_t begin_ = 0;
    SampleBlock now_;
};

/// Weighted sums of z^k, alone and multiplied by the other columns and the signals. Products of sines and
/// cosines are sums of sines and cosines, so the normal equations follow from these sums.
class PowerSums {
public:
    PowerSums(const HarmonicModel& m, std::size_t signals);
    SHAKER_WIDE void add(const SampleBlock& s) noexcept;
    [[nodiscard]] NormalEquations equations(const HarmonicModel& m) const;

private:
    /// Sum of w z^k; k may be negative.
    [[nodiscard]] std::complex<double> power(int k) const {
        const auto z = alone_[static_cast<std::size_t>(std::abs(k))];
        return k < 0 ? std::conj(z) : z;
    }

    int order_;
    std::size_t others_;
    std::vector<std::complex<double>> alone_;  // index k, 0..2 order
    // Multiplied by the other columns, then by the signals; index k, 0..order.
    std::vector<std::vector<std::complex<double>>> with_;
    Eigen::MatrixXd products_;  // of the other columns with themselves and the signals
};

constexpr std::size_t block = Phasors::size;

/// Eight sums that a processor adds at once.
using Channels [[gnu::vector_size(64)]] = double;

SHAKER_WITHIN void load(Channels& to, const BlockColumn& from, std::size_t i) noexcept {
    std::memcpy(&to, from.data() + i, sizeof to);
}

SHAKER_WITHIN double total(const Channels& c) noexcept {
    return ((c[0] + c[2]) + (c[4] + c[6])) + ((c[1] + c[3]) + (c[5] + c[7]));
}

/// Sum of products in a fixed order, independent of the compiler.
SHAKER_WITHIN double dot(const BlockColumn& a, const BlockColumn& b) noexcept {
    Channels sum{}, x, y;
    for (std::size_t i = 0; i < block; i += 8) {
        load(x, a, i);
        load(y, b, i);
        sum += x * y;
    }
    return total(sum);
}

SHAKER_WITHIN std::complex<double> dot_with(const Phasors& a, const BlockColumn& b) noexcept {
    Channels re{}, im{}, x, y, z;
    for (std::size_t i = 0; i < block; i += 8) {
        load(x, a.re, i);
        load(y, a.im, i);
        load(z, b, i);
        re += x * z;
        im += y * z;
    }
    return {total(re), total(im)};
}

SHAKER_WITHIN std::complex<double> sum_of(const Phasors& a) noexcept {
    Channels re{}, im{}, x, y;
    for (std::size_t i = 0; i < block; i += 8) {
        load(x, a.re, i);
        load(y, a.im, i);
        re += x;
        im += y;
    }
    return {total(re), total(im)};
}

Blocks::Blocks(const HarmonicModel& model, std::span<const double> t, std::span<const double> sd,
               std::span<const std::span<const double>> signals)
    : m_(model), t_(t), sd_(sd), signals_(signals) {
    for (int q = 1; q <= static_cast<int>(m_.derivative_of.size()); ++q)
        derivative_.push_back(two_pi * q * m_.derivative_of[static_cast<std::size_t>(q - 1)]);
    now_.values.resize(signals.size());
    now_.others.resize((m_.slope == Slope::free ? 1U : 0U) + (derivative_.empty() ? 0U : 1U));
}

const SampleBlock* Blocks::next() {
    if (begin_ >= t_.size()) return nullptr;
    now_.count = std::min(block, t_.size() - begin_);
    BlockColumn dt{}, turns;
    for (std::size_t i = 0; i < now_.count; ++i) dt[i] = t_[begin_ + i] - m_.origin_s;
    for (std::size_t i = 0; i < block; ++i) turns[i] = m_.frequency_hz * dt[i];
    now_.z = phasors(turns);
    for (std::size_t i = 0; i < block; ++i) now_.weight[i] = i < now_.count ? 1 : 0;
    if (!sd_.empty())
        for (std::size_t i = 0; i < now_.count; ++i) now_.weight[i] = 1 / (sd_[begin_ + i] * sd_[begin_ + i]);
    for (std::size_t s = 0; s < signals_.size(); ++s) {
        std::copy_n(signals_[s].begin() + static_cast<std::ptrdiff_t>(begin_), now_.count,
                    now_.values[s].begin());
        std::fill(now_.values[s].begin() + static_cast<std::ptrdiff_t>(now_.count), now_.values[s].end(),
                  0.0);
    }
    if (m_.slope == Slope::free)
        for (std::size_t i = 0; i < block; ++i) now_.others.front()[i] = dt[i] / m_.half_span_s;
    if (!derivative_.empty()) {
        const Phasors sum = polynomial(derivative_, now_.z);
        for (std::size_t i = 0; i < block; ++i) now_.others.back()[i] = dt[i] * sum.re[i];
    }
    begin_ += now_.count;
    return &now_;
}

PowerSums::PowerSums(const HarmonicModel& m, std::size_t signals)
    : order_(m.order),
      others_(static_cast<std::size_t>(m.columns() - 2 * m.order - 1)),
      alone_(2 * static_cast<std::size_t>(m.order) + 1),
      with_(others_ + signals, std::vector<std::complex<double>>(static_cast<std::size_t>(m.order) + 1)),
      products_(Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(others_),
                                      static_cast<Eigen::Index>(others_ + signals))) {}

void PowerSums::add(const SampleBlock& s) noexcept {
    const auto column = [&](std::size_t i) -> const BlockColumn& {
        return i < others_ ? s.others[i] : s.values[i - others_];
    };
    Phasors power{s.weight, {}};
    for (std::size_t k = 0; k < alone_.size(); ++k) {
        if (k > 0) multiply(power, s.z);
        alone_[k] += sum_of(power);
        if (k > static_cast<std::size_t>(order_)) continue;
        for (std::size_t i = 0; i < with_.size(); ++i) with_[i][k] += dot_with(power, column(i));
    }
    for (std::size_t i = 0; i < others_; ++i) {
        BlockColumn weighted;
        for (std::size_t n = 0; n < block; ++n) weighted[n] = s.weight[n] * s.others[i][n];
        for (std::size_t j = 0; j < with_.size(); ++j)
            products_(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) += dot(weighted, column(j));
    }
}

NormalEquations PowerSums::equations(const HarmonicModel& m) const {
    const int n = m.columns(), constant = m.constant_column();
    const Eigen::Index signals = products_.cols() - products_.rows();
    NormalEquations out{Eigen::MatrixXd::Zero(n, n), Eigen::MatrixXd::Zero(n, signals)};
    const auto set = [&](Eigen::Index i, Eigen::Index j, double x) {
        out.normal(std::max(i, j), std::min(i, j)) = x;
    };
    for (int p = 1; p <= order_; ++p) {
        const int sin_p = 2 * (p - 1), cos_p = sin_p + 1;
        for (int q = 1; q <= order_; ++q) {
            const int sin_q = 2 * (q - 1), cos_q = sin_q + 1;
            const std::complex<double> sum = power(p + q), difference = power(p - q);
            set(sin_p, sin_q, (difference.real() - sum.real()) / 2);
            set(cos_p, cos_q, (difference.real() + sum.real()) / 2);
            set(sin_p, cos_q, (sum.imag() + difference.imag()) / 2);
        }
        set(sin_p, constant, power(p).imag());
        set(cos_p, constant, power(p).real());
    }
    set(constant, constant, power(0).real());
    // The slope's column precedes the constant's, the derivative's follows it.
    const auto place = [&](std::size_t i) {
        return m.slope == Slope::free && i == 0 ? 2 * m.order : constant + 1;
    };
    for (std::size_t i = 0; i < with_.size(); ++i) {
        const auto column = static_cast<Eigen::Index>(i);
        for (int q = 0; q <= order_; ++q) {
            const std::complex<double> sum = with_[i][static_cast<std::size_t>(q)];
            const int sin_q = q > 0 ? 2 * (q - 1) : constant, cos_q = q > 0 ? sin_q + 1 : constant;
            if (i < others_) {
                if (q > 0) set(sin_q, place(i), sum.imag());
                set(cos_q, place(i), sum.real());
            } else {
                if (q > 0) out.right(sin_q, column - products_.rows()) = sum.imag();
                out.right(cos_q, column - products_.rows()) = sum.real();
            }
        }
        for (std::size_t j = 0; j < others_; ++j) {
            const double product = products_(static_cast<Eigen::Index>(j), column);
            if (i < others_)
                set(place(i), place(j), product);
            else
                out.right(place(j), column - products_.rows()) = product;
        }
    }
    return out;
}

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

/// Adds what the model with amplitudes `a` and parameters `p` leaves of signal k in a block.
SHAKER_WIDE void add_remainder(const HarmonicModel& model, const SampleBlock& s, std::size_t k,
                               std::span<const std::complex<double>> a, const Eigen::VectorXd& p,
                               Remainder& out) noexcept {
    BlockColumn left = polynomial(a, s.z).im;
    const double constant = p(model.constant_column());
    for (std::size_t i = 0; i < left.size(); ++i) left[i] = s.values[k][i] - left[i] - constant;
    if (model.slope == Slope::free) {
        const double slope = p(model.constant_column() - 1);
        for (std::size_t i = 0; i < left.size(); ++i) left[i] -= slope * s.others.front()[i];
    }
    if (!model.derivative_of.empty()) {
        const double derivative = p(p.size() - 1);
        for (std::size_t i = 0; i < left.size(); ++i) left[i] -= derivative * s.others.back()[i];
    }
    std::fill(left.begin() + static_cast<std::ptrdiff_t>(s.count), left.end(), 0.0);
    out.squares += dot(left, left);
    BlockColumn weighted;
    for (std::size_t i = 0; i < left.size(); ++i) weighted[i] = s.weight[i] * left[i];
    out.chi2 += dot(weighted, left);
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
    while (const SampleBlock* s = blocks.next())
        for (std::size_t k = 0; k < out.size(); ++k)
            add_remainder(model, *s, k, a[k], parameters.col(static_cast<Eigen::Index>(k)), out[k]);
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
