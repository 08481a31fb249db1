#include "daemon/reduction/selection.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>

#include "drivers/errors.hpp"

namespace shaker::reduction {
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
                             " s) is not later than the previous time (" + std::to_string(t[i - 1]) +
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
                             " m; both must be finite, and the standard deviation at least 0");
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
                         " s; must be finite and at least 0");
    }
}

/// Removes positions before `from` and after `to`.
void cut(MotionSeries& s, double from, double to) {
    const auto first = std::lower_bound(s.t_s.begin(), s.t_s.end(), from) - s.t_s.begin();
    const auto last = std::upper_bound(s.t_s.begin() + first, s.t_s.end(), to) - s.t_s.begin();
    for (std::vector<double>* list : {&s.t_s, &s.x_m, &s.sd_m}) {
        list->erase(list->begin() + last, list->end());
        list->erase(list->begin(), list->begin() + first);
    }
}

void raise_too_good(std::vector<double>& sd_m) {
    if (sd_m.empty()) return;
    std::vector<double> sorted = sd_m;
    const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
    std::nth_element(sorted.begin(), middle, sorted.end());
    const double floor = *middle > 0 ? *middle / 3 : 1e-6;
    for (double& sd : sd_m) sd = std::max(sd, floor);
}

/// Time covered by the frames of a view, lost ones included.
struct StreamSpan {
    std::string view;
    double from_s, to_s;
};

/// Checks and cuts the views; removes those without positions. Returns the time covered by their frames,
/// where known.
std::vector<StreamSpan> make_usable(std::vector<MotionSeries>& views, const std::string& target, double from,
                                    double to) {
    const std::size_t given = views.size();
    std::vector<StreamSpan> streams;
    for (MotionSeries& s : views) {
        require_sound(s, target + " in view '" + s.view + "'");
        const double half = calibration::median_step(s.t_s) / 2;  // as in span_of()
        if (s.stream_from_s <= s.stream_to_s)
            streams.push_back({s.view, s.stream_from_s - half, s.stream_to_s + half});
        cut(s, from, to);
        raise_too_good(s.sd_m);
    }
    std::erase_if(views, [](const MotionSeries& s) { return s.t_s.size() < 2; });
    if (views.empty()) {
        throw InputError(std::string("no ") + target + ": " + std::to_string(given) +
                         " views, none with two or more positions; at least one view must follow the " +
                         target);
    }
    return streams;
}

std::string words(const Span& s) { return number(s.from_s) + " to " + number(s.to_s) + " s"; }

/// why: what may be wrong when there is nothing in common.
void require_two_periods(double from, double to, double f, const std::string& streams,
                         const std::string& why = {}) {
    const double periods = std::max(0.0, (to - from) * f);
    if (periods < 2) {
        throw InputError(streams + " have " + number(std::round(periods * 100) / 100) + " drive periods of " +
                         number(f) + " Hz in common; at least 2 are required" + (periods > 0 ? "" : why));
    }
}

}  // namespace

Span span_of(std::span<const MotionSeries> views) {
    Span s{1e300, -1e300};
    for (const MotionSeries& v : views) {
        // A frame stands for its whole interval: 100 frames at 1 ms are 2 periods of 20 Hz, not 1.98.
        const double half = calibration::median_step(v.t_s) / 2;
        s.from_s = std::min(s.from_s, v.t_s.front() - half);
        s.to_s = std::max(s.to_s, v.t_s.back() + half);
    }
    return s;
}

double frames_per_period(std::span<const MotionSeries> views, double frequency_hz) {
    double most = 0;
    for (const MotionSeries& v : views) {
        const double step = calibration::median_step(v.t_s);
        if (step > 0) most = std::max(most, 1 / (step * frequency_hz));
    }
    return most;
}

Measurement usable_part(Measurement m) {
    const double f = m.frequency_hz;
    if (!(f >= 0.01 && f <= 10000)) {
        throw InputError("drive frequency " + std::to_string(f) + " Hz; must be 0.01 to 10000 Hz");
    }
    std::vector<StreamSpan> streams = make_usable(m.walkers, "walker", m.from_s, m.to_s);
    std::ranges::move(make_usable(m.bases, "base", m.from_s, m.to_s), std::back_inserter(streams));
    require_sound(m.accelerometer);
    const auto& accel = m.accelerometer;
    if (accel.t_s.size() < 2) {
        throw InputError("no accelerometer: " + std::to_string(accel.t_s.size()) +
                         " samples; at least 2 are required to measure the drive");
    }
    constexpr double rate_error = 1e-3;
    for (const auto* views : {&m.walkers, &m.bases}) {
        const double frames = frames_per_period(*views, f);
        if (frames < least_frames * (1 - rate_error)) {
            throw InputError("too few frames: " + number(std::round(frames * 100) / 100) +
                             " per drive period of " + number(f) + " Hz; at least 5 are required");
        }
    }
    const Span walker = span_of(m.walkers), base = span_of(m.bases);
    const double from = std::max(walker.from_s, base.from_s), to = std::min(walker.to_s, base.to_s);
    constexpr double rounding = 1e-9;
    require_two_periods(from - rounding, to + rounding, f, "walker and base");
    const double half = calibration::median_step(accel.t_s) / 2, reach = accel.clock_uncertainty_s + rounding;
    require_two_periods(std::max(from, accel.t_s.front() - half - reach),
                        std::min(to, accel.t_s.back() + half + reach), f, "cameras and accelerometer",
                        ": the accelerations run from " + words({accel.t_s.front(), accel.t_s.back()}) +
                            ", the pictures from " + words({from, to}) +
                            "; is one of them in another unit (ms, ns), or does it count from another zero?");
    for (const StreamSpan& s : streams) {
        require_two_periods(std::max(s.from_s, accel.t_s.front() - half - reach),
                            std::min(s.to_s, accel.t_s.back() + half + reach), f,
                            "view '" + s.view + "' and accelerometer");
    }
    require_two_periods(accel.t_s.front() - half - rounding, accel.t_s.back() + half + rounding, f,
                        "accelerometer samples alone");
    return m;
}

calibration::HarmonicSums sums_of(std::span<const MotionSeries> views, double frequency_hz, int order,
                                  calibration::Slope slope) {
    std::vector<calibration::HarmonicSamples> samples;
    for (const MotionSeries& v : views) samples.push_back({v.t_s, v.x_m, v.sd_m});
    return {samples, frequency_hz, order, slope};
}

ViewsFit fit_views(const calibration::HarmonicSums& sums, int order) {
    const calibration::HarmonicFit as_claimed = sums.fit(order);
    const double share =  // of the unknowns, by degrees of freedom of each view
        1 - static_cast<double>(2 * order + 2) / static_cast<double>(as_claimed.samples);
    ViewsFit out;
    // Data without noise still need finite weights.
    for (const double rms : as_claimed.stream_rms)
        out.scale.push_back(std::max(rms / std::sqrt(std::max(share, 0.1)), 1e-6));
    out.fit = sums.fit(order, out.scale);
    return out;
}

}  // namespace shaker::reduction
