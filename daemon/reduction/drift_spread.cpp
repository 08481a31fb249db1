#include "daemon/reduction/drift_spread.hpp"

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <limits>
#include <numbers>

namespace shaker::reduction {
namespace {

/// Differences of successive means: d = g D + noise, with a tridiagonal covariance.
struct Differences {
    std::vector<double> d, g, late;  // late: g times (time of the difference's middle - mean time)
    std::vector<double> c;           // weights in the straight line's slope
    std::vector<double> share;       // error variance of each period's mean, relative
};

Differences differences(std::span<const PeriodMean> means) {
    Differences out;
    double frames = 0, centre = 0, total = 0;
    for (const PeriodMean& m : means) {
        frames += m.frames;
        centre += static_cast<double>(m.frames) * m.k;
    }
    centre /= frames;
    const double typical = frames / static_cast<double>(means.size());
    for (const PeriodMean& m : means) {
        out.share.push_back(typical / m.frames);
        total += static_cast<double>(m.frames) * (m.k - centre) * (m.k - centre);
    }
    double later = 0;
    for (std::size_t i = 1; i < means.size(); ++i) {
        const double g = means[i].k - means[i - 1].k;
        later -= static_cast<double>(means[i - 1].frames) * (means[i - 1].k - centre) / total;
        out.d.push_back(means[i].y_m - means[i - 1].y_m);
        out.g.push_back(g);
        out.late.push_back(g * ((means[i].k + means[i - 1].k) / 2.0 - centre));
        out.c.push_back(later);
    }
    return out;
}

/// Inner products with the inverse of the tridiagonal covariance, for a given ratio of variances.
class Weighing {
public:
    Weighing(const Differences& x, double jitter, double error) {
        const std::size_t n = x.d.size();
        double variance_of_c = 0;
        for (std::size_t i = 0; i < n; ++i) {
            const double diagonal = jitter * (x.g[i] - 0.5) + error * (x.share[i] + x.share[i + 1]);
            const double beside = jitter / 4 - error * x.share[i];
            const double l = i > 0 ? beside / pivot_.back() : 0.0;
            pivot_.push_back(diagonal - (i > 0 ? l * beside : 0.0));
            below_.push_back(l);
            log_determinant_ += std::log(pivot_.back());
            variance_of_c += x.c[i] * (x.c[i] * diagonal + (i > 0 ? 2 * x.c[i - 1] * beside : 0.0));
        }
        slope_variance_ = variance_of_c;
    }
    [[nodiscard]] double log_determinant() const { return log_determinant_; }
    [[nodiscard]] double slope_variance() const { return slope_variance_; }
    /// L^-1 x, scaled: plain inner products of such vectors are inner products with the inverse covariance.
    [[nodiscard]] std::vector<double> whiten(const std::vector<double>& x) const {
        std::vector<double> z(x.size());
        double before = 0;
        for (std::size_t i = 0; i < x.size(); ++i) {
            before = x[i] - below_[i] * before;
            z[i] = before / std::sqrt(pivot_[i]);
        }
        return z;
    }

private:
    std::vector<double> pivot_, below_;
    double log_determinant_ = 0, slope_variance_ = 0;
};

double dot(const std::vector<double>& a, const std::vector<double>& b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
    return sum;
}

struct Candidate {
    double jitter2, error2;
    double log_weight;  // restricted likelihood
    double slope_sd;    // standard error of the line's slope
};

Candidate weigh(const Differences& x, double jitter2, double error2) {
    const Weighing v(x, jitter2, error2);
    const auto d = v.whiten(x.d), g = v.whiten(x.g);
    const double gg = dot(g, g), gd = dot(g, d);
    return {jitter2, error2, -0.5 * (v.log_determinant() + std::log(gg) + dot(d, d) - gd * gd / gg),
            std::sqrt(v.slope_variance())};
}

double spread_of(const Differences& x) {
    double sum = 0, squares = 0;
    for (const double d : x.d) sum += d;
    for (const double d : x.d) squares += std::pow(d - sum / static_cast<double>(x.d.size()), 2);
    return squares / std::max(1.0, static_cast<double>(x.d.size()) - 1);
}

struct Range {
    double low, high;
};

/// Candidates over a range of jitter^2, evenly spaced in its logarithm. The prior's exponent balances white
/// noise taken for jitter (sigma too large) against slight jitter taken for white noise (too small): with
/// 0.3, sigma is 3 times the scatter in the first case and covers 93 % at worst in the second.
std::vector<Candidate> over_jitter(const Differences& x, double error2, Range jitter2) {
    constexpr int steps = 24;
    std::vector<Candidate> out;
    for (int j = 0; j <= steps; ++j) {
        out.push_back(
            weigh(x, jitter2.low * std::pow(jitter2.high / jitter2.low, j / double{steps}), error2));
        out.back().log_weight += 0.3 * std::log(out.back().jitter2);
    }
    return out;
}

const Candidate& likeliest(const std::vector<Candidate>& all) {
    return *std::max_element(all.begin(), all.end(), [](const Candidate& a, const Candidate& b) {
        return a.log_weight < b.log_weight;
    });
}

/// The part of a coarse grid that has significant weight.
Range weighty(const std::vector<Candidate>& coarse) {
    const double enough = likeliest(coarse).log_weight - 14;
    std::size_t first = 0, last = coarse.size() - 1;
    while (coarse[first].log_weight < enough) ++first;
    while (coarse[last].log_weight < enough) --last;
    return {coarse[first > 0 ? first - 1 : 0].jitter2, coarse[std::min(last + 1, coarse.size() - 1)].jitter2};
}

struct Error {
    double variance;
    double log_prior;
};

/// Errors over the given range and, with a small prior, up to all the scatter of the differences: noise
/// correlated for longer than a period.
std::vector<Error> errors(const Differences& x, double least2, double most2) {
    constexpr double doubt = -4;
    std::vector<Error> out;
    const bool vague = most2 > 1.01 * least2;
    for (int i = 0; i <= (vague ? 4 : 0); ++i) out.push_back({least2 * std::pow(most2 / least2, i / 4.0), 0});
    const double all = spread_of(x) / 2;
    for (int i = 1; i <= 4 && all > most2; ++i)
        out.push_back({most2 * std::pow(all / most2, i / 4.0), doubt});
    return out;
}

/// For each error, jitter from negligible over the whole run to far above the scatter of the differences, in
/// finer steps where the weight is.
std::vector<Candidate> candidates(const Differences& x, double least2, double most2) {
    const double n = static_cast<double>(x.d.size()) + 1;
    std::vector<Candidate> out;
    for (const Error& e : errors(x, least2, most2)) {
        const Range all{0.01 * e.variance / (n * n), 1e3 * std::max(spread_of(x), e.variance)};
        const Range range = weighty(over_jitter(x, e.variance, all));
        auto fine = over_jitter(x, e.variance, range);
        // A candidate represents its step, whose size differs between the ranges.
        for (Candidate& c : fine) c.log_weight += e.log_prior + std::log(std::log(range.high / range.low));
        out.insert(out.end(), fine.begin(), fine.end());
    }
    return out;
}

double half_width_95(const std::vector<Candidate>& all, double best) {
    double low = 0, high = 0;
    for (const Candidate& c : all) high = std::max(high, 2 * c.slope_sd);
    for (int i = 0; i < 60; ++i) {
        const double h = (low + high) / 2;
        double outside = 0, total = 0;
        for (const Candidate& c : all) {
            const double weight = std::exp(c.log_weight - best);
            if (weight < 1e-9) continue;
            outside += weight * std::erfc(h / c.slope_sd / std::numbers::sqrt2);
            total += weight;
        }
        (outside > 0.05 * total ? low : high) = h;
    }
    return high;
}

void add_trend(const Differences& x, const Candidate& c, DriftSpread& out) {
    const Weighing v(x, c.jitter2, c.error2);
    const auto d = v.whiten(x.d), g = v.whiten(x.g), u = v.whiten(x.late);
    const double gg = dot(g, g), gu = dot(g, u), uu = dot(u, u), gd = dot(g, d), ud = dot(u, d);
    const double determinant = gg * uu - gu * gu;
    out.freedom = static_cast<int>(x.d.size()) - 2;
    if (out.freedom < 1 || !(determinant > 0)) return;
    const double mean = (uu * gd - gu * ud) / determinant, slope = (gg * ud - gu * gd) / determinant;
    const double rest = std::max(dot(d, d) - mean * gd - slope * ud, std::numeric_limits<double>::min());
    const double span = x.late.back() / x.g.back() - x.late.front() / x.g.front();
    out.trend_m = slope * span;
    out.trend_t = slope / std::sqrt(rest / out.freedom * gg / determinant);
}

}  // namespace

double few_periods_factor(int freedom) {
    if (freedom < 1) return std::numeric_limits<double>::infinity();
    return boost::math::quantile(boost::math::students_t(freedom), 0.975) / 2;
}

DriftSpread drift_spread(std::span<const PeriodMean> means, const ErrorOfMean& scatter) {
    DriftSpread out;
    if (means.size() < 3) {
        out.sigma_m = std::numeric_limits<double>::infinity();
        return out;
    }
    const Differences x = differences(means);
    // Positions without noise still have rounding errors, and a likelihood needs a width.
    const double least = std::max(scatter.least_m, 1e-15 + 1e-9 * std::sqrt(spread_of(x)));
    const double most = std::max(scatter.most_m, least);
    const auto all = candidates(x, least * least, most * most);
    const Candidate& best = likeliest(all);
    out.sigma_m = half_width_95(all, best.log_weight) / 2;
    out.jitter_m = std::sqrt(best.jitter2);
    out.mean_error_m = std::sqrt(best.error2);
    add_trend(x, best, out);
    return out;
}

}  // namespace shaker::reduction
