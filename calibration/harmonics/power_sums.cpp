#include "calibration/harmonics/power_sums.hpp"

#include <algorithm>

#include "drivers/drive.hpp"

namespace shaker::calibration {
namespace {

constexpr std::size_t block = Phasors::size;

std::complex<double> dot_with(const Phasors& a, const BlockColumn& b) noexcept {
    return {dot(a.re, b), dot(a.im, b)};
}

}  // namespace

double dot(const BlockColumn& a, const BlockColumn& b) noexcept {
    using Channels = Eigen::Array<double, 8, 1>;
    Channels sum = Channels::Zero();
    for (std::size_t i = 0; i < block; i += 8)
        sum += Eigen::Map<const Channels>(a.data() + i) * Eigen::Map<const Channels>(b.data() + i);
    return sum.sum();
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
    static constexpr BlockColumn ones = [] {
        BlockColumn c{};
        c.fill(1);
        return c;
    }();
    Phasors power{s.weight, {}};
    for (std::size_t k = 0; k < alone_.size(); ++k) {
        if (k > 0) multiply(power, s.z);
        alone_[k] += dot_with(power, ones);
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

}  // namespace shaker::calibration
