#include "daemon/reduction/drift_spread.hpp"

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <limits>

namespace shaker {
namespace {

/// Differences of successive means: d = g D + noise with a tridiagonal covariance.
struct Differences {
    std::vector<double> d, g, late;  // late: g times the time of the difference's middle about the mean
    std::vector<double> c;           // weights with which they enter the straight line's slope
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

/// Inner products with the inverse of the tridiagonal covariance of a given ratio of variances.
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
    /// L^-1 x, scaled so that plain inner products of such vectors are those with the covariance's inverse.
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
    double ratio;       // jitter^2 / error^2
    double log_weight;  // restricted likelihood, the common scale integrated out
    double slope_sd;    // standard error of the line's slope
    double scale;       // error^2
};

Candidate weigh(const Differences& x, double ratio) {
    const Weighing v(x, ratio, 1);
    const auto d = v.whiten(x.d), g = v.whiten(x.g);
    const double freedom = static_cast<double>(x.d.size()) - 1;
    const double gg = dot(g, g), gd = dot(g, d);
    const double rest = std::max(dot(d, d) - gd * gd / gg, std::numeric_limits<double>::min());
    return {ratio, -0.5 * (v.log_determinant() + std::log(gg) + freedom * std::log(rest)),
            std::sqrt(rest / freedom * v.slope_variance()), rest / freedom};
}

/// Ratios from "the error hides any jitter, even over the whole run" to "jitter only".
std::vector<Candidate> candidates(const Differences& x) {
    constexpr int steps = 28;
    const double n = static_cast<double>(x.d.size()) + 1;
    const double low = 0.3 / (n * n), high = 300;
    std::vector<Candidate> out{weigh(x, 0)};
    for (int i = 0; i < steps; ++i) out.push_back(weigh(x, low * std::pow(high / low, i / (steps - 1.0))));
    return out;
}

double half_width_95(const std::vector<Candidate>& all, double best, int freedom) {
    const boost::math::students_t t(freedom);
    double low = 0, high = 0;
    for (const Candidate& c : all) high = std::max(high, c.slope_sd);
    high *= boost::math::quantile(t, 0.975) * 1.001;
    for (int i = 0; i < 50; ++i) {
        const double h = (low + high) / 2;
        double outside = 0, total = 0;
        for (const Candidate& c : all) {
            const double weight = std::exp(c.log_weight - best);
            if (weight < 1e-9) continue;
            outside += weight * 2 * boost::math::cdf(boost::math::complement(t, h / c.slope_sd));
            total += weight;
        }
        (outside > 0.05 * total ? low : high) = h;
    }
    return high;
}

void add_trend(const Differences& x, const Candidate& c, DriftSpread& out) {
    const Weighing v(x, c.ratio, 1);
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

DriftSpread drift_spread(std::span<const PeriodMean> means) {
    DriftSpread out;
    if (means.size() < 3) {
        out.sigma_m = std::numeric_limits<double>::infinity();
        return out;
    }
    const Differences x = differences(means);
    const auto all = candidates(x);
    const Candidate* best = all.data();
    for (const Candidate& c : all) {
        if (c.log_weight > best->log_weight) best = &c;
    }
    out.sigma_m = half_width_95(all, best->log_weight, static_cast<int>(x.d.size()) - 1) / 2;
    out.jitter_m = std::sqrt(best->ratio * best->scale);
    out.mean_error_m = std::sqrt(best->scale);
    add_trend(x, *best, out);
    return out;
}

}  // namespace shaker
