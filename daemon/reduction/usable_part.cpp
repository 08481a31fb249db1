#include "daemon/reduction/usable_part.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "drivers/errors.hpp"

namespace shaker {
namespace {

std::string number(double x) {
    std::string s = std::to_string(x);
    s.erase(s.find_last_not_of('0') + 1);
    if (s.back() == '.') s.pop_back();
    return s;
}

void require_increasing(const std::vector<double>& t, const std::string& name) {
    for (std::size_t i = 0; i < t.size(); ++i) {
        if (!std::isfinite(t[i])) {
            throw InputError(name + ": time " + std::to_string(i) + " is not a finite number");
        }
        if (i > 0 && !(t[i] > t[i - 1])) {
            throw InputError(name + ": time " + std::to_string(i) + " (" + std::to_string(t[i]) +
                             " s) is not later than the one before (" + std::to_string(t[i - 1]) +
                             " s); times must increase");
        }
    }
}

void require_sound(const MotionSeries& s, const std::string& name) {
    if (s.x_m.size() != s.t_s.size() || s.sd_m.size() != s.t_s.size()) {
        throw InputError(name + ": " + std::to_string(s.t_s.size()) + " times but " +
                         std::to_string(s.x_m.size()) + " positions and " + std::to_string(s.sd_m.size()) +
                         " standard deviations");
    }
    require_increasing(s.t_s, name);
    for (std::size_t i = 0; i < s.t_s.size(); ++i) {
        if (!std::isfinite(s.x_m[i]) || !std::isfinite(s.sd_m[i]) || s.sd_m[i] < 0) {
            throw InputError(name + ": position " + std::to_string(i) + " is " + std::to_string(s.x_m[i]) +
                             " m with standard deviation " + std::to_string(s.sd_m[i]) +
                             " m; both must be finite, the second not negative");
        }
    }
}

void require_sound(const AccelSeries& s) {
    if (s.a_mps2.size() != s.t_s.size()) {
        throw InputError("accelerometer: " + std::to_string(s.t_s.size()) + " times but " +
                         std::to_string(s.a_mps2.size()) + " samples");
    }
    require_increasing(s.t_s, "accelerometer");
    for (std::size_t i = 0; i < s.a_mps2.size(); ++i) {
        for (const double a : s.a_mps2[i]) {
            if (!std::isfinite(a)) {
                throw InputError("accelerometer: sample " + std::to_string(i) + " is not a finite number");
            }
        }
    }
    if (!(s.clock_uncertainty_s >= 0) || !std::isfinite(s.clock_uncertainty_s)) {
        throw InputError("accelerometer: clock uncertainty " + std::to_string(s.clock_uncertainty_s) +
                         " s; it must be 0 or more");
    }
}

MotionSeries cut(const MotionSeries& s, double from, double to) {
    MotionSeries out;
    out.view = s.view;
    out.lost = s.lost;
    for (std::size_t i = 0; i < s.t_s.size(); ++i) {
        if (s.t_s[i] < from || s.t_s[i] > to) continue;
        out.t_s.push_back(s.t_s[i]);
        out.x_m.push_back(s.x_m[i]);
        out.sd_m.push_back(s.sd_m[i]);
    }
    if (out.sd_m.empty()) return out;
    std::vector<double> sorted = out.sd_m;
    std::sort(sorted.begin(), sorted.end());
    const double median = sorted[sorted.size() / 2];
    const double floor = median > 0 ? median / 3 : 1e-6;
    for (double& sd : out.sd_m) sd = std::max(sd, floor);
    return out;
}

std::vector<MotionSeries> cut_all(const std::vector<MotionSeries>& views, const std::string& target,
                                  const Measurement& m) {
    std::vector<MotionSeries> out;
    for (const MotionSeries& s : views) {
        require_sound(s, target + " in view '" + s.view + "'");
        MotionSeries part = cut(s, m.from_s, m.to_s);
        if (part.t_s.size() >= 2) out.push_back(std::move(part));
    }
    if (out.empty()) {
        throw InputError(std::string("no ") + target + ": " + std::to_string(views.size()) +
                         " views, none with two or more positions; at least one view must follow the " +
                         target);
    }
    return out;
}

void require_two_periods(double from, double to, double f, const std::string& streams) {
    const double periods = std::max(0.0, (to - from) * f);
    if (periods < 2) {
        throw InputError(streams + " have " + number(std::round(periods * 100) / 100) + " drive periods of " +
                         number(f) + " Hz in common; at least 2 are needed");
    }
}

}  // namespace

Span span_of(std::span<const MotionSeries> views) {
    Span s{1e300, -1e300};
    for (const MotionSeries& v : views) {
        // A frame stands for its whole interval: 100 frames of 1 ms are 2 periods of 20 Hz, not 1.98.
        const double half = median_step(v.t_s) / 2;
        s.from_s = std::min(s.from_s, v.t_s.front() - half);
        s.to_s = std::max(s.to_s, v.t_s.back() + half);
    }
    return s;
}

double frames_per_period(std::span<const MotionSeries> views, double frequency_hz) {
    double most = 0;
    for (const MotionSeries& v : views) {
        const double step = median_step(v.t_s);
        if (step > 0) most = std::max(most, 1 / (step * frequency_hz));
    }
    return most;
}

Measurement usable_part(const Measurement& m) {
    const double f = m.frequency_hz;
    if (!(f >= 0.01 && f <= 10000)) {
        throw InputError("drive frequency " + std::to_string(f) + " Hz; allowed are 0.01 to 10000 Hz");
    }
    Measurement out = m;
    out.walkers = cut_all(m.walkers, "walker", m);
    out.bases = cut_all(m.bases, "base", m);
    require_sound(m.accelerometer);
    const auto& accel = m.accelerometer;
    if (accel.t_s.size() < 2) {
        throw InputError("no accelerometer: " + std::to_string(accel.t_s.size()) +
                         " samples; the drive is measured with it");
    }
    // Cameras slower than this alias the drive: nothing below would notice.
    for (const auto* views : {&out.walkers, &out.bases}) {
        if (frames_per_period(*views, f) < 3) {
            throw InputError(
                "too few frames: " + number(std::round(frames_per_period(*views, f) * 100) / 100) +
                " a drive period; at least 3 are needed");
        }
    }
    const Span walker = span_of(out.walkers), base = span_of(out.bases);
    const double from = std::max(walker.from_s, base.from_s), to = std::min(walker.to_s, base.to_s);
    constexpr double rounding = 1e-9;
    require_two_periods(from - rounding, to + rounding, f, "walker and base");
    const double half = median_step(accel.t_s) / 2, reach = accel.clock_uncertainty_s + rounding;
    require_two_periods(std::max(from, accel.t_s.front() - half - reach),
                        std::min(to, accel.t_s.back() + half + reach), f, "cameras and accelerometer");
    for (const auto* views : {&m.walkers, &m.bases}) {
        for (const MotionSeries& v : *views) {
            const double step = median_step(v.t_s) / 2;  // as in span_of()
            if (v.stream_from_s > v.stream_to_s) continue;
            require_two_periods(std::max(v.stream_from_s - step, accel.t_s.front() - half - reach),
                                std::min(v.stream_to_s + step, accel.t_s.back() + half + reach), f,
                                "view '" + v.view + "' and accelerometer");
        }
    }
    require_two_periods(accel.t_s.front() - half - rounding, accel.t_s.back() + half + rounding, f,
                        "accelerometer samples alone");
    return out;
}

namespace {

std::vector<HarmonicSamples> samples_of(std::span<const MotionSeries> views,
                                        const std::vector<std::vector<double>>& sd) {
    std::vector<HarmonicSamples> out;
    for (std::size_t v = 0; v < views.size(); ++v) out.push_back({views[v].t_s, views[v].x_m, sd[v]});
    return out;
}

}  // namespace

ViewsFit fit_views(std::span<const MotionSeries> views, double frequency_hz, int order, Slope slope) {
    ViewsFit out;
    for (const MotionSeries& v : views) out.sd.push_back(v.sd_m);
    out.fit = fit_harmonics(samples_of(views, out.sd), frequency_hz, order, slope);
    const double share =  // of the unknowns, in each view's own degrees of freedom
        1 - static_cast<double>(2 * order + 2) / static_cast<double>(out.fit.samples);
    for (std::size_t v = 0; v < views.size(); ++v) {
        double chi2 = 0;
        for (std::size_t i = 0; i < views[v].t_s.size(); ++i) {
            const double t = views[v].t_s[i];
            const double model =
                out.fit.constants[v] + out.fit.slope.value * (t - out.fit.origin_s) + out.fit.periodic(t);
            const double r = (views[v].x_m[i] - model) / out.sd[v][i];
            chi2 += r * r;
        }
        const double freedom = static_cast<double>(views[v].t_s.size()) * std::max(share, 0.1);
        // Data without any noise still need finite weights.
        out.scale.push_back(std::max(std::sqrt(chi2 / freedom), 1e-6));
        for (double& sd : out.sd[v]) sd *= out.scale.back();
    }
    out.fit = fit_harmonics(samples_of(views, out.sd), frequency_hz, order, slope);
    return out;
}

}  // namespace shaker
