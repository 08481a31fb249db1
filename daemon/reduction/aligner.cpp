#include "daemon/reduction/aligner.hpp"

#include <spdlog/fmt/fmt.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

#include "calibration/accelerometer/transverse.hpp"
#include "daemon/reduction/check/corner.hpp"
#include "daemon/reduction/clock_drift.hpp"
#include "daemon/reduction/lag_choice.hpp"
#include "daemon/reduction/selection.hpp"
#include "drivers/drive.hpp"
#include "drivers/errors.hpp"

namespace shaker::reduction {
namespace {

constexpr double clock_prior = 300e-6;  // one sigma of an untrimmed crystal, with margin

std::string rounded(double x, int digits) {
    std::array<char, 64> text{};
    std::snprintf(text.data(), text.size(), "%.*f", digits, x);
    return text.data();
}

/// `count` samples from `first` on, projected on a direction in sensor axes.
std::vector<double> along(const std::array<double, 3>& u, const AccelSeries& s, std::size_t first,
                          std::size_t count) {
    std::vector<double> y;
    y.reserve(count);
    for (std::size_t i = 0; i < count; ++i) {
        const auto& a = s.a_mps2[first + i];
        y.push_back(a[0] * u[0] + a[1] * u[1] + a[2] * u[2]);
    }
    return y;
}

/// Principal direction of the motion at harmonics 1 and 2; its largest component is positive.
Eigen::Vector3d principal_axis(std::span<const double> t, const AccelSeries& s, std::size_t first, double f,
                               int order) {
    const std::vector<double> x = along({1, 0, 0}, s, first, t.size()),
                              y = along({0, 1, 0}, s, first, t.size()),
                              z = along({0, 0, 1}, s, first, t.size());
    const std::array<std::span<const double>, 3> axes{x, y, z};
    const std::vector<calibration::HarmonicFit> fits = calibration::fit_signals(t, axes, f, order);
    Eigen::Matrix3Xd lock_in(3, 4);
    lock_in.setZero();
    for (int k = 0; k < 3; ++k) {
        const calibration::HarmonicFit& fit = fits[static_cast<std::size_t>(k)];
        for (int q = 1; q <= std::min(order, 2); ++q) {
            lock_in(k, q - 1) = fit.at(q).real();
            lock_in(k, q + 1) = fit.at(q).imag();
        }
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(lock_in * lock_in.transpose());
    Eigen::Vector3d axis = eigen.eigenvectors().col(2);
    Eigen::Index largest = 0;
    axis.cwiseAbs().maxCoeff(&largest);
    return axis(largest) < 0 ? Eigen::Vector3d(-axis) : axis;
}

/// Accelerometer samples within a window of its own clock, and results on that clock.
struct OwnClock {
    std::size_t first = 0;
    std::span<const double> t;
    std::vector<double> along;
    Eigen::Vector3d axis;
    calibration::Estimate frequency;
    calibration::HarmonicFit fit;
};

OwnClock on_own_clock(const AccelSeries& s, Span window, const calibration::Estimate& near) {
    const double near_hz = near.value;
    OwnClock out;
    const auto low = std::lower_bound(s.t_s.begin(), s.t_s.end(), window.from_s);
    const auto high = std::upper_bound(low, s.t_s.end(), window.to_s);
    out.first = static_cast<std::size_t>(low - s.t_s.begin());
    out.t = {low, high};
    const double step = calibration::median_step(out.t);
    const double span = out.t.empty() ? 0.0 : out.t.back() - out.t.front() + step;
    if (span * near_hz < 2 - 1e-6) {
        throw InputError("cameras and accelerometer have " + rounded(span * near_hz, 2) +
                         " drive periods in common; at least 2 are needed");
    }
    const double rate = 1 / (step * near_hz);
    const int few = calibration::order_for(rate, 4);
    const Eigen::Vector3d given(s.shaker_axis[0], s.shaker_axis[1], s.shaker_axis[2]);
    out.axis = given.norm() > 0 ? Eigen::Vector3d(given.normalized())
                                : principal_axis(out.t, s, out.first, near_hz, few);
    out.along = along({out.axis(0), out.axis(1), out.axis(2)}, s, out.first, out.t.size());
    const calibration::HarmonicSamples samples{out.t, out.along, {}};
    out.frequency = refine_frequency({&samples, 1}, near, few);
    if (!std::isfinite(out.frequency.sigma)) out.frequency = {near_hz, clock_prior * near_hz};
    out.fit = fit_harmonics({&samples, 1}, out.frequency.value, few, calibration::Slope::none);
    return out;
}

/// Harmonics of the base's position up to the highest above the noise.
calibration::HarmonicFit base_motion(const Measurement& m, double f) {
    int order = calibration::order_for(frames_per_period(m.bases, f), 12);
    const calibration::HarmonicSums sums = sums_of(m.bases, f, order, calibration::Slope::none);
    calibration::HarmonicFit fit = fit_views(sums, order).fit;
    while (order > 2 && !fit.stands_out(order)) --order;
    return order < fit.order() ? fit_views(sums, order).fit : fit;
}

calibration::Estimate base_frequency(const Measurement& m) {
    if (m.frequency_is_exact) return {m.frequency_hz, 0};
    std::vector<calibration::HarmonicSamples> samples;
    for (const auto& v : m.bases) samples.push_back({v.t_s, v.x_m, v.sd_m});
    return refine_frequency(samples, m.frequency_hz,
                            calibration::order_for(frames_per_period(m.bases, m.frequency_hz), 2));
}

struct Clock {
    double rate = 1;    // master seconds per own second
    double own = 0;     // accelerometer's clock, s ...
    double master = 0;  // ... and master time of the same instant
    calibration::Estimate late, ppm;
    calibration::Estimate delay;  // own minus master time at `own`
    bool flipped = false;
    [[nodiscard]] double at(double t) const { return master + (t - own) * rate; }
    [[nodiscard]] double inverse(double t) const { return own + (t - master) / rate; }
};

struct Lag {
    Clock clock;
    bool compared = false;  // the clocks were compared by the motion
    calibration::Estimate frequency;
};

/// Frequency and clock rate from the frequencies on both clocks and the prior of the rate.
Lag rates(const Measurement& m, const calibration::Estimate& base, const OwnClock& own) {
    Lag out;
    if (m.accelerometer.dac_clock && m.frequency_is_exact) {  // one clock
        out.clock.ppm = {0, 0};
        out.frequency = base;
        return out;
    }
    const double ratio = own.frequency.value / base.value - 1;
    const double variance =
        std::pow(base.sigma / base.value, 2) + std::pow(own.frequency.sigma / base.value, 2);
    const double gain =
        m.frequency_is_exact ? 1.0 : clock_prior * clock_prior / (clock_prior * clock_prior + variance);
    const double ppm = gain * ratio, sd = std::sqrt(variance * gain);
    out.clock.rate = 1 + ppm;
    out.clock.ppm = {1e6 * ppm, 1e6 * sd};
    const double f = own.frequency.value / out.clock.rate;
    out.frequency =
        m.frequency_is_exact ? base : calibration::Estimate{f, std::hypot(own.frequency.sigma, f * sd)};
    return out;
}

void set_lag(Lag& lag, const OwnClock& own, const calibration::HarmonicFit& base, const AccelSeries& s,
             std::vector<std::string>& notes) {
    const double w = two_pi * lag.frequency.value;
    const auto common = common_motion(own.fit, base);
    Clock& c = lag.clock;
    c.own = own.fit.origin_s;
    if (common.empty()) {
        notes.emplace_back(
            "the base does not move enough to compare the clocks; the accelerometer's clock was used "
            "unchanged");
        c.master = c.own;
        c.late = c.delay = {0, s.clock_uncertainty_s / std::sqrt(3.0)};
        return;
    }
    const LagPrior prior{.uncertainty_s = s.clock_uncertainty_s,
                         .axis_given = s.shaker_axis != std::array<double, 3>{},
                         .since_first_s = c.own - s.t_s.front(),
                         .rate = c.rate - 1,
                         .rate_sd = 1e-6 * c.ppm.sigma};
    const LagChoice lags = choose_lag(common, lag.frequency.value, c.own - base.origin_s, prior, notes);
    lag.compared = true;
    c.flipped = lags.flipped;
    c.master = c.own - lags.late_s;
    double information = 0;
    for (const CommonHarmonic& h : common) information += std::pow(h.q * w, 2) / h.phase_variance;
    const double across = (c.master - base.origin_s) * lag.frequency.sigma / lag.frequency.value;
    const double spread2 = lags.spread_s * lags.spread_s;
    c.delay = {lags.late_s, std::sqrt(1 / information + across * across + spread2)};
    c.late = {c.own * c.rate - c.master,
              std::sqrt(1 / information + std::pow(c.own * prior.rate_sd, 2) + across * across + spread2)};
    if (std::abs(lags.first_s) > s.clock_uncertainty_s + 3 / std::sqrt(information) +
                                     3 * prior.rate_sd * std::abs(prior.since_first_s)) {
        notes.push_back("the accelerometer's stamps are " + rounded(1e3 * lags.first_s, 3) +
                        " ms late, more than its clock uncertainty of " +
                        rounded(1e3 * s.clock_uncertainty_s, 3) + " ms");
    }
}

/// Notes a rate that no crystal has, and whose it is: that of the clock with which neither the other one nor
/// the nominal frequency agrees.
void note_rate(const Measurement& m, const calibration::Estimate& base, const OwnClock& own, Alignment& out,
               std::vector<std::string>& notes) {
    const calibration::Estimate& ppm = out.ppm;
    constexpr double crystal_ppm = 100;  // one sigma
    const double most_ppm = 4 * std::hypot(crystal_ppm, ppm.sigma);
    if (std::abs(ppm.value) <= most_ppm) return;
    const double cameras = base.value / m.frequency_hz - 1, sensor = own.frequency.value / m.frequency_hz - 1;
    const auto right = [&](double share) { return 1e6 * std::abs(share) <= most_ppm; };
    const bool of_sensor = m.frequency_is_exact || (right(cameras) && !right(sensor)),
               of_cameras = !of_sensor && right(sensor) && !right(cameras);
    const std::string verdict =
        of_sensor    ? "The sample rate in the settings is off; v_D does not depend on it"
        : of_cameras ? fmt::format(
                           "The frame rate in the settings is off by {} %, since accelerometer and "
                           "nominal frequency agree; {} it",
                           rounded(100 * cameras, 3), frame_rate_note)
                     : fmt::format(
                           "Check the frame rate and the sample rate in the settings; {} the "
                           "difference",
                           frame_rate_note);
    notes.push_back("the accelerometer's clock is " + rounded(ppm.value, 0) + " +- " + rounded(ppm.sigma, 0) +
                    " ppm off that of the " + (m.frequency_is_exact ? "drive" : "cameras") +
                    "; a crystal is within 400 ppm. " + verdict +
                    " (frequency by the accelerometer's clock " + rounded(own.frequency.value, 4) +
                    " Hz, by the " + (m.frequency_is_exact ? "drive " : "cameras' ") +
                    rounded(base.value, 4) + " Hz, nominal " + rounded(m.frequency_hz, 4) + " Hz)");
    if (of_cameras) out.frame_rate_off = cameras;
    if (!of_sensor) out.frame_rate_error = std::abs(of_cameras ? cameras : 1e-6 * ppm.value);
}

/// Share of the residuals that is noise: what repeats with the drive is harmonics beyond the fitted ones, as
/// of the walker's kinks. Residuals in narrow ranges of the phase scatter about their mean by the noise.
double noise_share(const calibration::HarmonicFit& fit, std::span<const double> t_s,
                   std::span<const double> y) {
    constexpr std::size_t most_ranges = 1000, a_range = 4, least_freedom = 50;  // samples
    struct Range {
        double sum = 0;
        std::size_t count = 0;
    };
    std::vector<Range> ranges(std::clamp<std::size_t>(y.size() / a_range, 1, most_ranges));
    std::vector<double> periodic(y.size());
    fit.periodic(t_s, periodic);
    double squares = 0;
    for (std::size_t i = 0; i < y.size(); ++i) {
        const double turns = fit.frequency_hz * (t_s[i] - fit.origin_s),
                     r = y[i] - fit.constants[0] - periodic[i];
        const double place = (turns - std::floor(turns)) * static_cast<double>(ranges.size());
        Range& range = ranges[std::min(static_cast<std::size_t>(place), ranges.size() - 1)];
        range.sum += r;
        ++range.count;
        squares += r * r;
    }
    std::size_t used = 0;
    for (const Range& range : ranges) {
        if (range.count == 0) continue;
        ++used;
        squares -= range.sum * range.sum / static_cast<double>(range.count);
    }
    if (y.size() < used + least_freedom) return 1;
    return std::min(1.0, std::sqrt(squares / static_cast<double>(y.size() - used)) / fit.scale);
}

void fit_acceleration(const AccelSeries& s, std::size_t first, Alignment& out) {
    const double f = out.frequency.value, rate = 1 / (calibration::median_step(out.t_s) * f);
    const auto axes = calibration::across_axes(out.shaker_axis);
    const std::vector<double> aside = along(axes[0], s, first, out.t_s.size()),
                              up = along(axes[1], s, first, out.t_s.size());
    const std::array<std::span<const double>, 3> signals{out.along_mps2, aside, up};
    std::vector<calibration::HarmonicFit> fits =
        calibration::fit_signals(out.t_s, signals, f, calibration::order_for(rate, max_harmonics));
    out.acceleration = std::move(fits[0]);
    const double noise = noise_share(out.acceleration, out.t_s, out.along_mps2);
    out.acceleration.scale *= noise;
    for (double& c : out.acceleration.covariance) c *= noise * noise;
    out.across = {std::move(fits[1]), std::move(fits[2])};
}

/// Widens the errors of delay and rate: by the scatter of the windows, and by a walk of q s per square root
/// of s that a straight line leaves. A line through a walk of length T has the error q sqrt(T/12) in the
/// middle and q sqrt(6/(5T)) in its slope. Less than 5 % is not worth a change.
void widen(Alignment& out, double own_s, double factor, double walk_s_rts) {
    const double T = out.t_s.back() - out.t_s.front();
    const double delay = walk_s_rts * std::sqrt(T / 12), rate = walk_s_rts * std::sqrt(1.2 / T);
    const auto add = [&](double& sigma, double walk) {
        const double wide = std::hypot(factor * sigma, walk);
        if (wide > 1.05 * sigma) sigma = wide;
    };
    add(out.delay_s.sigma, delay);
    add(out.late_s.sigma, std::hypot(delay, own_s * rate));
    add(out.ppm.sigma, 1e6 * rate);
}

/// Replaces the straight line of the accelerometer's clock where windows of the motion show that it drifts.
void follow_drift(const Measurement& m, const Clock& clock, Alignment& out, std::vector<std::string>& notes) {
    constexpr int few_windows = 64, many_windows = 256;
    const auto windows = [&](int most) {
        return delays_in_windows(m.bases, out.base, out.t_s, out.along_mps2, out.acceleration, most);
    };
    const WindowDelays delays = windows(few_windows);
    ClockDrift drift = drift_of(delays.differences(), clock.master);
    if (!drift.significant()) {
        const double factor = drift.scatters() ? drift.scatter : 1;
        widen(out, clock.own, factor, unconfirmed_walk(delays));
        return;
    }
    const std::vector<double> line = out.t_s;
    // Delays are linear for small ones only, so the rest is measured once more.
    for (int pass = 0; pass < 2; ++pass) {
        for (std::size_t i = 0; i < line.size(); ++i) out.t_s[i] = line[i] - drift.at(line[i]);
        fit_acceleration(m.accelerometer, out.first_sample, out);
        std::vector<WindowDelay> rest = windows(many_windows).differences();
        for (WindowDelay& d : rest) d.delay_s.value += drift.at(d.t_s);
        drift = drift_of(rest, clock.master);
    }
    for (std::size_t i = 0; i < line.size(); ++i) out.t_s[i] = line[i] - drift.at(line[i]);
    fit_acceleration(m.accelerometer, out.first_sample, out);
    const double rate = clock.rate * (1 - drift.rate.value);
    out.ppm = {1e6 * (rate - 1), std::hypot(out.ppm.sigma, 1e6 * drift.rate.sigma)};
    out.delay_s = {clock.own - clock.master + drift.middle_s.value,
                   std::hypot(out.delay_s.sigma, drift.middle_s.sigma)};
    out.late_s = {out.delay_s.value + clock.own * (rate - 1),
                  std::hypot(out.delay_s.sigma, 1e-6 * clock.own * out.ppm.sigma)};
    notes.push_back("the accelerometer's clock drifts: its delay deviates by up to " +
                    rounded(1e6 * drift.farthest_from_line(clock.master), 1) +
                    " us from a straight line; it was followed in " + std::to_string(drift.t_s.size()) +
                    " windows");
}

}  // namespace

Alignment align(const Measurement& m, std::vector<std::string>& notes) {
    const calibration::Estimate raw = base_frequency(m);
    const bool moving = raw.sigma < 0.003 * raw.value;  // false for NaN
    const calibration::Estimate base_f =
        moving ? raw : calibration::Estimate{m.frequency_hz, clock_prior * m.frequency_hz};
    const Span walker = span_of(m.walkers), base = span_of(m.bases);
    const Span common{std::max(walker.from_s, base.from_s), std::min(walker.to_s, base.to_s)};
    // First with all samples that may overlap the cameras' span, then with those that do.
    const double reach = m.accelerometer.clock_uncertainty_s;
    Span window{common.from_s - reach, common.to_s + reach};
    constexpr double unknown = std::numeric_limits<double>::infinity();
    Alignment out;
    OwnClock own;
    Lag lag;
    for (int pass = 0; pass < 2; ++pass) {
        std::vector<std::string> pass_notes;
        own = on_own_clock(m.accelerometer, window,
                           pass == 0 ? calibration::Estimate{base_f.value, unknown} : own.frequency);
        lag = rates(m, base_f, own);
        if (pass == 0) out.base = base_motion(m, lag.frequency.value);
        set_lag(lag, own, out.base, m.accelerometer, pass_notes);
        window = {lag.clock.inverse(common.from_s), lag.clock.inverse(common.to_s)};
        if (pass == 1) notes.insert(notes.end(), pass_notes.begin(), pass_notes.end());
    }
    const double sign = lag.clock.flipped ? -1 : 1;
    out.t_s.reserve(own.t.size());
    for (const double t : own.t) out.t_s.push_back(lag.clock.at(t));
    out.along_mps2 = std::move(own.along);
    if (lag.clock.flipped)
        for (double& a : out.along_mps2) a = -a;
    for (int k = 0; k < 3; ++k) out.shaker_axis[static_cast<std::size_t>(k)] = sign * own.axis(k);
    out.frequency = lag.frequency;
    out.late_s = lag.clock.late;
    out.delay_s = lag.clock.delay;
    out.ppm = lag.clock.ppm;
    note_rate(m, base_f, own, out, notes);
    out.first_sample = own.first;
    fit_acceleration(m.accelerometer, own.first, out);
    if (lag.compared && !m.accelerometer.dac_clock) follow_drift(m, lag.clock, out, notes);
    return out;
}

Corner take_off(const SensorResponse& stated, double exposure_s, Alignment& drive) {
    const calibration::HarmonicFit before = drive.acceleration;
    const auto [corner, later_s, variance_s2] =
        take_off(stated, exposure_s, drive.base, drive.acceleration, drive.across);
    if (stated.none()) return corner;
    std::vector<double> old(drive.t_s.size()), now(drive.t_s.size());
    before.periodic(drive.t_s, old);
    drive.acceleration.periodic(drive.t_s, now);
    for (std::size_t i = 0; i < now.size(); ++i) {
        drive.along_mps2[i] += now[i] - old[i];
        drive.t_s[i] += later_s;
    }
    for (calibration::HarmonicFit* fit : {&drive.acceleration, &drive.across[0], &drive.across[1]})
        fit->origin_s += later_s;
    for (calibration::Estimate* late : {&drive.late_s, &drive.delay_s}) {
        late->value -= later_s;
        late->sigma = std::sqrt(late->sigma * late->sigma + std::max(0.0, variance_s2));
    }
    return corner;
}

}  // namespace shaker::reduction
