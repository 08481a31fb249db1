#include "daemon/reduction/drift.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "drivers/errors.hpp"

namespace shaker::reduction {
namespace {

constexpr int most_harmonics = 12;  // more would follow noise rather than the kinks

std::vector<Residual> residuals_of(std::span<const MotionSeries> views, const ViewsFit& motion) {
    std::vector<Residual> out;
    std::size_t positions = 0;
    for (const MotionSeries& view : views) positions += view.t_s.size();
    out.reserve(positions);
    const calibration::HarmonicFit& fit = motion.fit;
    for (std::size_t v = 0; v < views.size(); ++v) {
        const MotionSeries& view = views[v];
        std::vector<double> periodic(view.t_s.size());
        fit.periodic(view.t_s, periodic);
        for (std::size_t i = 0; i < view.t_s.size(); ++i) {
            const double t = view.t_s[i];
            const double line = fit.constants[v] + fit.slope.value * (t - fit.origin_s);
            out.push_back({t, view.x_m[i] - line - periodic[i], view.sd_m[i] * motion.scale[v]});
        }
    }
    std::stable_sort(out.begin(), out.end(),
                     [](const Residual& a, const Residual& b) { return a.t_s < b.t_s; });
    return out;
}

std::string percent(double x) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.2f %%", 100 * x);
    return text.data();
}

/// Views with different scales see different drifts of one walker. Half the difference, as an error of both.
double disagreement(std::span<const MotionSeries> views, const calibration::HarmonicSums& sums, double v_D,
                    std::vector<std::string>& notes) {
    if (views.size() < 2) return 0;
    std::size_t lowest = 0, highest = 0;
    std::vector<calibration::Estimate> v;
    for (std::size_t i = 0; i < views.size(); ++i) {
        if (views[i].t_s.size() < 2 * static_cast<std::size_t>(sums.order()) + 4) return 0;
        v.push_back(sums.of_stream(i).fit(sums.order()).slope);
        if (v[i].value < v[lowest].value) lowest = i;
        if (v[i].value > v[highest].value) highest = i;
    }
    const double apart = v[highest].value - v[lowest].value;
    // Least-squares errors for white noise are too small for tracks whose errors depend on the image: 4
    // sigma, not 2.
    if (apart <= 4 * std::hypot(v[highest].sigma, v[lowest].sigma)) return 0;
    if (apart > 0.005 * std::abs(v_D)) {
        notes.push_back("views '" + views[lowest].view + "' and '" + views[highest].view +
                        "' differ in v_D by " + percent(apart / std::max(std::abs(v_D), 1e-12)) +
                        "; half of the difference is included in its error");
    }
    return apart / 2;
}

double rms_claimed(std::span<const MotionSeries> views) {
    double sum = 0, n = 0;
    for (const auto& v : views) {
        for (const double sd : v.sd_m) sum += sd * sd;
        n += static_cast<double>(v.sd_m.size());
    }
    return std::sqrt(sum / n);
}

/// Error of a period's mean. Lower bound: from the scatter within quarters of periods (white noise), or from
/// the contrast first - second - third + fourth of the quarters' means, which a steady drift cancels from. If
/// the contrast exceeds the white noise, the noise is correlated and a mean over four quarters is worse than
/// the contrast shows, by up to a factor of 2: upper bound.
ErrorOfMean error_of_mean(std::span<const Residual> residuals, double start_s, double frequency_hz) {
    struct Quarter {
        double n = 0, y = 0, yy = 0;
    };
    double squares = 0, within = 0, freedom = 0, frames = 0, periods = 0;
    for (std::size_t i = 0; i < residuals.size();) {
        const double k = std::floor((residuals[i].t_s - start_s) * frequency_hz);
        std::array<Quarter, 4> q;
        for (; i < residuals.size(); ++i) {
            const double part = ((residuals[i].t_s - start_s) * frequency_hz - k) * 4;
            if (part >= 4) break;
            Quarter& here = q[static_cast<std::size_t>(std::max(part, 0.0))];
            ++here.n;
            here.y += residuals[i].y_m;
            here.yy += residuals[i].y_m * residuals[i].y_m;
        }
        bool whole = true;
        for (Quarter& c : q) {
            whole = whole && c.n > 0;
            if (c.n == 0) continue;
            c.y /= c.n;
            within += std::max(0.0, c.yy - c.n * c.y * c.y);
            freedom += c.n - 1;
            frames += c.n;
        }
        if (!whole) continue;
        const double contrast = (q[0].y - q[1].y - q[2].y + q[3].y) / 4;
        squares += contrast * contrast;
        ++periods;
    }
    const double white2 = freedom > 0 && periods > 0 ? within / freedom / (frames / periods) : 0.0;
    // The periodic fit removed the mean of the contrasts: one degree of freedom less.
    const double between2 = periods > 1 ? squares / (periods - 1) : 0.0;
    const double least2 = std::max(white2, between2);
    const double memory = white2 > 0 ? std::clamp(between2 / white2, 1.0, 4.0) : 4.0;
    return {std::sqrt(least2), std::sqrt(least2 * memory)};
}

}  // namespace

std::vector<PeriodMean> period_means(std::span<const Residual> residuals, double start_s,
                                     double frequency_hz) {
    struct Sums {
        double weight = 0, y = 0, first = 0, last = 0;
        int frames = 0;
    };
    std::vector<PeriodMean> out;
    Sums now;
    int k = -1;
    const auto finish = [&] {
        if (k >= 0 && now.frames > 0) out.push_back({k, now.y / now.weight, now.frames});
        now = {};
    };
    for (const Residual& r : residuals) {
        const double periods = (r.t_s - start_s) * frequency_hz;
        if (periods < 0) continue;
        const int of = static_cast<int>(periods);
        if (of != k) finish();
        k = of;
        const double w = 1 / (r.sd_m * r.sd_m);
        now.weight += w;
        now.y += w * r.y_m;
        ++now.frames;
    }
    finish();
    std::vector<int> counts;
    counts.reserve(out.size());
    for (const auto& m : out) counts.push_back(m.frames);
    if (counts.empty()) return out;
    std::sort(counts.begin(), counts.end());
    const double usual = counts[counts.size() / 2];
    std::erase_if(out, [&](const PeriodMean& m) { return m.frames < 0.9 * usual; });
    return out;
}

Drift measure_drift(std::span<const MotionSeries> walkers, double frequency_hz,
                    std::vector<std::string>& notes) {
    Drift out;
    const int order = calibration::order_for(frames_per_period(walkers, frequency_hz), most_harmonics);
    const calibration::HarmonicSums sums = sums_of(walkers, frequency_hz, order, calibration::Slope::free);
    out.motion = fit_views(sums, order);
    out.residuals = residuals_of(walkers, out.motion);
    out.residual_m = {out.motion.fit.rms, rms_claimed(walkers)};
    const calibration::Estimate line = out.motion.fit.slope;
    // Periods start at the first frame, so that a record of n whole periods gives n means for any phase of
    // the drive.
    const double start_s = span_of(walkers).from_s;
    const auto means = period_means(out.residuals, start_s, frequency_hz);
    double sigma = 3 * line.sigma;
    if (means.size() < 3) {
        notes.push_back(std::to_string(means.size()) +
                        " whole periods are too few to measure the scatter of the drift; its error is 3 "
                        "times that of the fit");
    } else {
        out.spread = drift_spread(means, error_of_mean(out.residuals, start_s, frequency_hz));
        sigma = std::max(line.sigma, out.spread.sigma_m * frequency_hz);
    }
    const DriftSpread& s = out.spread;
    if (s.freedom >= 1 && std::abs(s.trend_t) > 3.4 * few_periods_factor(s.freedom)) {
        notes.push_back("the walker is still settling: D changes by " +
                        percent(s.trend_m * frequency_hz / line.value) +
                        " over the run; v_D's error includes its value at the end");
        sigma += std::abs(s.trend_m) * frequency_hz / 4;
    }
    out.v_D = {line.value, std::hypot(sigma, disagreement(walkers, sums, line.value, notes))};
    return out;
}

}  // namespace shaker::reduction
