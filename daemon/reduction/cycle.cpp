#include "daemon/reduction/cycle.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>

#include "drivers/drive.hpp"

namespace shaker::reduction {
namespace {

/// Slow wandering of the walker about its straight line: period means joined by straight lines.
class Wander {
public:
    Wander(const Drift& drift, double start_s, double frequency_hz) {
        const auto means = period_means(drift.residuals, start_s, frequency_hz);
        if (means.size() < 3) return;
        for (const PeriodMean& m : means) {
            t_.push_back(start_s + (m.k + 0.5) / frequency_hz);
            y_.push_back(m.y_m);
        }
    }
    [[nodiscard]] double at(double t) const {
        if (t_.empty()) return 0;
        const auto next = std::upper_bound(t_.begin(), t_.end(), t);
        if (next == t_.begin()) return y_.front();
        if (next == t_.end()) return y_.back();
        const auto i = static_cast<std::size_t>(next - t_.begin());
        return y_[i - 1] + (y_[i] - y_[i - 1]) * (t - t_[i - 1]) / (t_[i] - t_[i - 1]);
    }

private:
    std::vector<double> t_, y_;
};

/// Number of phases that differ by more than 1/200 of a period.
int distinct_phases(std::span<const Folded> folded) {
    int count = 0;
    double last = -1;
    for (const Folded& s : folded) {
        if (s.phase - last <= 0.005) continue;
        last = s.phase;
        ++count;
    }
    return count;
}

struct Local {
    calibration::Estimate x, slope;  // slope per period
    double scale = NAN;              // scatter in units of the positions' errors
};

/// Quartic through the samples within `reach` of phase p. NaN when there are too few or they are too close
/// together.
Local quartic_at(std::span<const Folded> folded, double p, double reach) {
    std::array<double, 9> moments{};  // of w u^k: all the normal equations need
    Eigen::Matrix<double, 5, 1> right = Eigen::Matrix<double, 5, 1>::Zero();
    double squares = 0;
    int count = 0;
    for (const double turn : {-1.0, 0.0, 1.0}) {
        const auto first = std::lower_bound(folded.begin(), folded.end(), p - reach - turn,
                                            [](const Folded& s, double value) { return s.phase < value; });
        for (auto s = first; s != folded.end() && s->phase + turn <= p + reach; ++s) {
            const double u = (s->phase + turn - p) / reach, w = 1 / (s->sd_m * s->sd_m);
            double power = w;
            for (int k = 0; k < 9; ++k) {
                moments[static_cast<std::size_t>(k)] += power;
                if (k < 5) right(k) += power * s->x_m;
                power *= u;
            }
            squares += w * s->x_m * s->x_m;
            ++count;
        }
    }
    if (count < 6) return {};
    Eigen::Matrix<double, 5, 5> normal;
    for (int i = 0; i < 5; ++i) {
        for (int k = 0; k < 5; ++k)
            normal(i, k) = moments[static_cast<std::size_t>(i) + static_cast<std::size_t>(k)];
    }
    const Eigen::LDLT<Eigen::Matrix<double, 5, 5>> ldlt(normal);
    if (!(ldlt.rcond() > 1e-9)) return {};
    const Eigen::Matrix<double, 5, 1> c = ldlt.solve(right);
    const Eigen::Matrix<double, 5, 5> inverse = ldlt.solve(Eigen::Matrix<double, 5, 5>::Identity());
    const double scale = std::sqrt(std::max(0.0, (squares - c.dot(right)) / (count - 5)));
    return {{c(0), scale * std::sqrt(inverse(0, 0))},
            {c(1) / reach, scale * std::sqrt(inverse(1, 1)) / reach},
            scale};
}

/// Offset of the frames' phases within 1/n of a period when they repeat in every period; else 0.
double grid_offset(std::span<const Folded> folded, int n) {
    std::complex<double> sum = 0;
    for (const Folded& s : folded) sum += std::polar(1.0, two_pi * n * s.phase);
    sum /= static_cast<double>(folded.size());
    const double turn = std::arg(sum) / two_pi;
    return std::abs(sum) > 0.98 ? (turn < 0 ? turn + 1 : turn) / n : 0.0;
}

}  // namespace

BaseCycle::BaseCycle(const calibration::HarmonicFit& acceleration)
    : period_s_(1 / acceleration.frequency_hz) {
    const double w = two_pi * acceleration.frequency_hz, alpha1 = std::arg(acceleration.at(1));
    start_s_ = acceleration.origin_s - alpha1 / w;
    for (int q = 1; q <= acceleration.order(); ++q) {
        const std::complex<double> a = acceleration.at(q) * std::polar(1.0, -q * alpha1), iqw{0, q * w};
        a_.push_back(a);
        v_.push_back(a / iqw);
        x_.push_back(a / (iqw * iqw));
    }
}

double BaseCycle::sum(const Terms& terms, double p) noexcept {
    const std::complex<double> z = std::polar(1.0, two_pi * (p - std::rint(p)));
    std::complex<double> s = 0;
    for (auto it = terms.rbegin(); it != terms.rend(); ++it) s = (s + *it) * z;
    return s.imag();
}

double BaseCycle::start_after(double t_s) const noexcept {
    return start_s_ + std::ceil((t_s - start_s_) / period_s_) * period_s_;
}

std::vector<Folded> fold(std::span<const MotionSeries> walkers, const Drift& drift, double t0_s,
                         double frequency_hz) {
    const Wander wander(drift, span_of(walkers).from_s, frequency_hz);
    const calibration::HarmonicFit& fit = drift.motion.fit;
    std::vector<Folded> out;
    out.reserve(drift.residuals.size());
    for (std::size_t v = 0; v < walkers.size(); ++v) {
        for (std::size_t i = 0; i < walkers[v].t_s.size(); ++i) {
            const double t = walkers[v].t_s[i], p = (t - t0_s) * frequency_hz;
            const double line = fit.constants[v] + fit.slope.value * (t - fit.origin_s);
            out.push_back({p - std::floor(p), walkers[v].x_m[i] - line - wander.at(t),
                           walkers[v].sd_m[i] * drift.motion.scale[v]});
        }
    }
    std::stable_sort(out.begin(), out.end(),
                     [](const Folded& a, const Folded& b) { return a.phase < b.phase; });
    return out;
}

SmoothedCycle smoothed_cycle(std::span<const Folded> folded, const BaseCycle& base, double v_D,
                             double frames_per_period) {
    const double T = base.period_s();
    const int n = std::clamp(static_cast<int>(std::lround(frames_per_period)), 50, 200);
    const double dense = std::clamp(std::max(frames_per_period, distinct_phases(folded) / 2.0), 8.0, 200.0);
    const double reach = 3.499 / dense, offset = grid_offset(folded, n);
    const double start = quartic_at(folded, 0, reach).x.value;
    SmoothedCycle out;
    std::vector<double> scales;
    Cycle& cycle = out.cycle;
    for (int i = 0; i < n; ++i) {
        const double p = offset + static_cast<double>(i) / n;
        const Local local = quartic_at(folded, p, reach);
        cycle.phase.push_back(p);
        cycle.x_m.push_back(local.x.value - start + v_D * p * T);
        cycle.x_sd_m.push_back(local.x.sigma);
        cycle.v_mps.push_back(local.slope.value / T + v_D);
        cycle.v_sd_mps.push_back(local.slope.sigma / T);
        cycle.v_base_mps.push_back(base.v(p));
        if (local.scale > 0) scales.push_back(local.scale);
    }
    if (!scales.empty()) {
        const auto middle = scales.begin() + static_cast<std::ptrdiff_t>(scales.size() / 2);
        std::ranges::nth_element(scales, middle);
        out.scale = *middle;
    }
    return out;
}

}  // namespace shaker::reduction
