#include "daemon/reduction/reduction.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <limits>
#include <numbers>
#include <numeric>
#include <optional>
#include <utility>

#include "daemon/reduction/aligner.hpp"
#include "daemon/reduction/bad_samples.hpp"
#include "daemon/reduction/base_motion.hpp"
#include "daemon/reduction/check/corner.hpp"
#include "daemon/reduction/check/unseen_motion.hpp"
#include "daemon/reduction/cycle.hpp"
#include "daemon/reduction/drift.hpp"
#include "daemon/reduction/kinked_motion.hpp"
#include "daemon/reduction/selection.hpp"
#include "daemon/reduction/stick.hpp"
#include "drivers/drive.hpp"
#include "drivers/errors.hpp"

namespace shaker::reduction {
namespace {

/// Largest change of v_D that the change of the drive during the record explains, m/s. By the exact Coulomb
/// law from 0.5 to 3 g, |dv_D| < gamma/omega (|dgamma|/gamma / 2 + |dphi| / 5); a change of rho shows in
/// gamma. A change within two of its errors does not count.
double drive_effect(const std::vector<PeriodResult>& periods, const Reduction& r) {
    const auto n = static_cast<std::ptrdiff_t>(periods.size()), first = std::max<std::ptrdiff_t>(n / 8, 1);
    if (n < 3) return 0;
    const auto mean = [&](std::ptrdiff_t from, std::ptrdiff_t to, auto of) {
        double sum = 0;
        for (auto i = from; i < to; ++i) sum += of(periods[static_cast<std::size_t>(i)]);
        return sum / static_cast<double>(to - from);
    };
    const double share = std::sqrt(1.0 / static_cast<double>(n / 3) + 1.0 / static_cast<double>(first));
    const auto change = [&](auto of, auto error) {
        const double noise = share * mean(0, n, error);
        return std::max(0.0, std::abs(mean(n - n / 3, n, of) - mean(0, first, of)) - 2 * noise);
    };
    const double gamma = change([](const PeriodResult&p) { return p.gamma.value; },
                                [](const PeriodResult&p) { return p.gamma.sigma; }),
                 phi = change(
                     [&](const PeriodResult&p) { return std::remainder(p.phi.value - r.phi.value, two_pi); },
                     [](const PeriodResult&p) { return p.phi.sigma; });
    constexpr double margin = 2;
    return margin * (gamma / 2 + r.gamma.value * phi / 5) / (two_pi * r.frequency.value);
}

/// Adds the drift of the walker to a table of the drive.
std::vector<PeriodResult> with_drift(std::vector<PeriodResult> table, const Drift& drift, double t0_s,
                                     double f) {
    const auto means = period_means(drift.residuals, t0_s, f);
    double white = 0;
    for (const Residual& r : drift.residuals) white += r.sd_m * r.sd_m;
    white /= static_cast<double>(drift.residuals.size());
    for (std::size_t i = 0; i < means.size(); ++i) {
        auto row = std::lower_bound(table.begin(), table.end(), means[i].k,
                                    [](const PeriodResult& p, int k) { return p.k < k; });
        if (row == table.end() || row->k != means[i].k) {
            row = table.insert(row, PeriodResult{});
            row->k = means[i].k;
            row->t_s = t0_s + means[i].k / f;
        }
        row->frames = means[i].frames;
        if (i == 0 || means[i - 1].k + 1 != means[i].k) continue;
        const double error2 = std::max(2 * drift.spread.mean_error_m * drift.spread.mean_error_m,
                                       white / means[i].frames + white / means[i - 1].frames);
        row->drift = {drift.v_D.value / f + means[i].y_m - means[i - 1].y_m, std::sqrt(error2)};
    }
    return table;
}

/// Raises sigma to the scatter between periods if that is larger than the error of the fit. turn: two_pi for
/// angles.
void widen_by_scatter(calibration::Estimate& e, const std::vector<PeriodResult>& periods,
                      calibration::Estimate PeriodResult::*member, double turn) {
    double squares = 0;
    int n = 0;
    for (const PeriodResult& p : periods) {
        const double d = std::remainder((p.*member).value - e.value, turn);
        if (!std::isfinite(d)) continue;
        squares += d * d;
        ++n;
    }
    if (n >= 4) e.sigma = std::max(e.sigma, std::sqrt(squares / (n - 1) / n) * few_periods_factor(n - 1));
}

int sum_of(const std::vector<MotionSeries>& views, int MotionSeries::*count) {
    return std::accumulate(views.begin(), views.end(), 0,
                           [&](int sum, const MotionSeries& v) { return sum + v.*count; });
}

/// frames: those in which it was found; 0: not said.
void note_lost(const char* body, int lost, int repeated, int frames, std::vector<std::string>& notes) {
    if (lost == 0) return;
    notes.push_back(fmt::format(
        "the {} was lost in {}{} frames; these frames are excluded{}", body, lost,
        frames > 0 ? fmt::format(" of {}", frames + lost) : "",
        repeated > 0 ? fmt::format("; {} of them repeat rows of an earlier frame (delivered twice, or torn): "
                                   "check the camera's link and its frame rate",
                                   repeated)
                     : ""));
}

/// "300 clipped, 12 marks perhaps mistaken for their neighbours"; and what to do about it.
std::array<std::string, 2> causes_of(const MotionSeries& v) {
    struct Cause {
        int frames;
        const char *name, *advice;
    };
    std::array<std::string, 2> out;
    for (const Cause& c :
         {Cause{v.clipped, "clipped", "shorten the exposure or dim the light"},
          {v.slipped, "marks perhaps mistaken for their neighbours",
           "keep the marks in view, or use a code of irregular bars"},
          {v.doubtful - v.clipped - v.slipped, "partly hidden, blurred, or of a body that turns",
           "check light, focus, and what hides it"}}) {
        if (c.frames == 0) continue;
        const char* const between = out[0].empty() ? "" : ", ";
        out[0] += fmt::format("{}{} {}", between, c.frames, c.name);
        out[1] += between + std::string{c.advice};
    }
    return out;
}

/// Leaves out views of a body in which most places are in doubt, where another view shows it; a note for each
/// view with such places. Where all views are in doubt, the result is degraded.
void judge_doubtful(const char* body, std::vector<MotionSeries>& views, Reduction& out) {
    const bool other = std::ranges::any_of(
        views, [](const MotionSeries& v) { return !v.with_doubtful && v.t_s.size() > 1; });
    for (const MotionSeries& v : views) {
        if (v.doubtful == 0) continue;
        const std::string effect = !v.with_doubtful ? "these are excluded"
                                   : other          ? "this view is left out"
                                                    : fmt::format("all count: {}", degraded_note);
        const auto [causes, advice] = causes_of(v);
        out.notes.push_back(
            fmt::format("camera \"{}\": the place of the {} is in doubt in {} frames ({}), {}; {}; {}",
                        v.view, body, v.doubtful, causes,
                        v.with_doubtful ? "most of them" : fmt::format("not in {} others", v.t_s.size()),
                        effect, advice));
        out.degraded = out.degraded || (v.with_doubtful && !other);
    }
    if (other) std::erase_if(views, [](const MotionSeries& v) { return v.with_doubtful; });
}

calibration::Estimate ratio(double value, const calibration::Estimate& over,
                            const calibration::Estimate& under) {
    const double by_top = over.sigma / under.value, by_bottom = value * under.sigma / under.value;
    return {value, std::hypot(by_top, by_bottom)};
}

void note_tilt(const Reduction& r, std::vector<std::string>& notes) {
    constexpr double alarm = 4;  // standard errors
    const Tilt& t = r.tilt;
    const bool known = std::isfinite(t.angle.sigma);
    if (!(std::abs(t.angle.value) > alarm * (known ? t.angle.sigma : t.noise))) return;
    if (!(std::abs(t.v_D.value) > alarm * r.v_D.sigma)) return;
    notes.push_back(fmt::format(
        "bench check: gravity shows a tilt of {:+.3f} mrad ({:+.3f} deg; positive: +x downhill){}, which "
        "moves v_D by about {:+.2g} mm/s of {:.4g} mm/s (estimate by mu = {:.3f}); {}",
        1e3 * t.angle.value, t.angle.value * 180 / std::numbers::pi,
        known ? fmt::format(" +- {:.2g} mrad", 1e3 * t.angle.sigma)
              : ", if the accelerometer has no offset (it is not calibrated)",
        1e3 * t.v_D.value, 1e3 * r.v_D.value, t.mu,
        known ? "level the base, or measure also at phi + 180 deg"
              : "calibrate the accelerometer (\"shakerd calibrate accelerometer\") or level the base"));
}

void note_unmeasured(const AccelSeries& s, std::vector<std::string>& notes) {
    if (s.axes < 3)
        notes.push_back(fmt::format(
            "motion across the shaker's axis is not known: the accelerometer measures {} of 3 axes", s.axes));
    if (!s.gravity)
        notes.emplace_back("tilt by gravity is not known: the accelerometer's reading has no gravity");
}

/// Tells a drive that does not have the frequency of the fit, which somebody stated.
void doubt_frequency(const calibration::HarmonicFit& acceleration, Reduction& out) {
    constexpr double explained = 0.3;  // residuals over gamma; the noise of a usable sensor is far less
    const double f = acceleration.frequency_hz, rest = acceleration.rms / out.gamma.value;
    std::string why;
    if (const int times = times_too_low(acceleration); times > 1)
        why = fmt::format("the base moves at multiples of {:.4g} Hz only", times * f);
    else if (rest > explained)
        why = fmt::format(
            "{:.4g} Hz and its multiples leave residuals of {:.0f} % of gamma in the accelerations", f,
            100 * rest);
    else
        return;
    out.notes.push_back(
        fmt::format("{}: is {:.4g} Hz the drive's frequency? gamma, rho and phi may be those of "
                    "the wrong harmonics; {}",
                    why, f, degraded_note));
    out.degraded = true;
}

/// Gain of the cameras over the accelerometer, tilt, and the shares of the calibrations in the errors.
void check_bench(const Measurement& m, const Alignment& drive, Reduction& out) {
    const double f = drive.frequency.value;
    const std::optional<calibration::Tumble>& sensor = m.accelerometer.calibration;
    const double gain_error = sensor ? sensor->gain_error(drive.shaker_axis) : 0;
    std::vector<SeenBase> views;
    for (const MotionSeries& v : m.bases) {
        const calibration::HarmonicSamples samples{v.t_s, v.x_m, v.sd_m};
        if (m.bases.size() == 1) {  // fitted already
            views.push_back({v.view, drive.base, samples, v.exposure_s, v.scale_error});
            break;
        }
        const int order =
            std::min(drive.base.order(), calibration::order_for(frames_per_period({&v, 1}, f), 12));
        if (v.t_s.size() > static_cast<std::size_t>(3 * order))
            views.push_back({v.view, fit_harmonics({&samples, 1}, f, order, calibration::Slope::none),
                             samples, v.exposure_s, v.scale_error});
    }
    out.gain_ratio = gain_ratio(drive.acceleration, views, gain_error);
    GainRatio at_right_rate = out.gain_ratio;  // acceleration goes as the square of the cameras' rate
    for (ViewRatio& v : at_right_rate.views) v.ratio.value /= std::pow(1 + drive.frame_rate_off, 2);
    note_gain(at_right_rate, drive.acceleration, views, gain_error, out.notes);
    out.gain_ratio.alarm = at_right_rate.alarm;
    note_corner(out.corner, f, out.notes);
    out.gain_ratio.alarm = out.gain_ratio.alarm || out.corner.alarm;
    out.degraded = out.degraded || out.corner.large;
    if (std::string unseen = unseen_motion(drive.acceleration, views); !unseen.empty()) {
        out.notes.push_back(std::move(unseen));
        out.degraded = true;
    }

    if (m.accelerometer.gravity)
        out.tilt = tilt_of({&drive.acceleration,
                            {&drive.across[0], &drive.across[1]},
                            drive.shaker_axis,
                            m.accelerometer.shaker_axis == std::array<double, 3>{},
                            &sensor});
    const Cycle& c = out.cycle;
    set_share(out.tilt, drive.acceleration, friction_in_slip(c.phase, c.v_mps, c.v_base_mps, f),
              out.v_D.value);
    note_tilt(out, out.notes);
    note_unmeasured(m.accelerometer, out.notes);

    double scale = 0, weight = 0;
    bool known = true;
    for (const MotionSeries& w : m.walkers) {  // weights of the views in v_D; their errors may be common
        double information = 0;
        for (const double sd : w.sd_m) information += 1 / (sd * sd);
        scale += information * w.scale_error;
        weight += information;
        known = known && w.scale_error > 0;
    }
    Systematic& s = out.systematic;
    s.phi = out.corner.phi_told;
    if (known) {
        s.v_D = std::abs(out.v_D.value) * scale / weight;
        s.D = std::abs(out.D.value) * scale / weight;
    }
    if (gain_error > 0) {
        s.gamma = out.gamma.value * gain_error;
        s.v_rms = out.v_rms.value * gain_error;
    }
    if (known && gain_error > 0) s.efficiency = out.efficiency.value * std::hypot(scale / weight, gain_error);
}

/// The same with an error that contains this share of it.
calibration::Estimate with_share(const calibration::Estimate& e, double share) {
    return share == 0 ? e : calibration::Estimate{e.value, std::hypot(e.sigma, share * e.value)};
}

/// Root mean square of the views' exposures.
double exposure_of(const std::vector<MotionSeries>& bases) {
    double squares = 0;
    for (const MotionSeries& b : bases)
        squares += b.exposure_s * b.exposure_s / static_cast<double>(bases.size());
    return std::sqrt(squares);
}

}  // namespace

std::vector<calibration::ResponseLine> response_lines(Measurement measurement) {
    Reduction judged;
    judge_doubtful("base", measurement.bases, judged);
    Measurement m = usable_part(std::move(measurement));
    BadSamples bad;
    const Alignment drive = align_without_bad_samples(m, bad, judged.notes);
    if (judged.degraded || bad.degrade())
        throw InputError{fmt::format("not used: {}", fmt::join(judged.notes, "; "))};
    return lines_of(drive.acceleration, drive.base, exposure_of(m.bases));
}

Reduction reduce(Measurement measurement) {
    Reduction out;
    for (const MotionSeries& w : measurement.walkers) out.frames_doubtful += w.doubtful;
    judge_doubtful("walker", measurement.walkers, out);
    judge_doubtful("base", measurement.bases, out);
    out.frames_lost = sum_of(measurement.walkers, &MotionSeries::lost);
    const int walkers_repeated = sum_of(measurement.walkers, &MotionSeries::repeated);
    const int lost_bases = sum_of(measurement.bases, &MotionSeries::lost);
    const int repeated_bases = sum_of(measurement.bases, &MotionSeries::repeated);
    Measurement m = usable_part(std::move(measurement));
    for (const MotionSeries& w : m.walkers) out.frames += static_cast<int>(w.t_s.size());
    note_lost("walker", out.frames_lost, walkers_repeated, out.frames, out.notes);
    note_lost("base", lost_bases, repeated_bases, 0, out.notes);
    BadSamples bad;
    Alignment drive = align_without_bad_samples(m, bad, out.notes);
    out.corner = take_off(m.accelerometer.response, exposure_of(m.bases), drive);
    out.samples = static_cast<int>(bad.tested);
    out.samples_bad = static_cast<int>(bad.count());
    out.degraded = out.degraded || bad.degrade();
    const double f = drive.frequency.value;
    out.frequency = with_share(drive.frequency, drive.frame_rate_error);
    out.accelerometer_late_s = drive.late_s;
    out.accelerometer_ppm = drive.ppm;
    out.delay_s = drive.delay_s;
    out.shaker_axis = drive.shaker_axis;

    const BaseCycle base(drive.acceleration);
    out.t0_s = base.start_after(span_of(m.walkers).from_s);
    const BaseMotion asked = drive_measured(drive.acceleration);
    out.gamma = asked.gamma;
    out.rho = asked.rho;
    out.phi = asked.phi;
    out.v_rms = {asked.v_rms.value,
                 std::hypot(asked.v_rms.sigma, asked.v_rms.value * out.frequency.sigma / f)};
    out.harmonics = asked.harmonics;
    if (!m.frequency_is_exact) doubt_frequency(drive.acceleration, out);
    measure_across(drive, m.accelerometer.axes, out.harmonics);

    auto periods = drive_by_period(drive.acceleration, drive.t_s, drive.along_mps2, out.t0_s);
    const Drift drift = measure_drift(m.walkers, f, drive_effect(periods, out), out.notes);
    out.v_D = with_share(drift.v_D, drive.frame_rate_error);
    out.v_D_settled = with_share(drift.settled, drive.frame_rate_error);
    out.D = {drift.v_D.value / f,
             std::hypot(drift.v_D.sigma / f, drift.v_D.value * drive.frequency.sigma / (f * f))};
    out.fit_residual_x_m = drift.residual_m;
    out.efficiency = ratio(std::abs(out.v_D.value) / out.v_rms.value, out.v_D, out.v_rms);
    out.periods = with_drift(std::move(periods), drift, out.t0_s, f);
    widen_by_scatter(out.gamma, out.periods, &PeriodResult::gamma, std::numeric_limits<double>::infinity());
    widen_by_scatter(out.phi, out.periods, &PeriodResult::phi, two_pi);

    const auto folded = fold(m.walkers, drift, out.t0_s, f);
    const double frames = frames_per_period(m.walkers, f);
    SmoothedCycle smoothed = smoothed_cycle(folded, base, out.v_D.value, frames);
    const Sticks sticks = find_sticks(folded, smoothed.cycle, base, out.v_D, frames);
    out.stick = sticks.found;
    out.shortest_visible_stick = sticks.shortest_visible;
    double longest = 0;
    for (const MotionSeries& w : m.walkers) longest = std::max(longest, w.exposure_s);
    const KinkedMotion kinked =
        kinked_motion(folded, sticks.kinks, base, out.v_D.value, smoothed, frames, longest);
    out.cycle = std::move(smoothed.cycle);
    for (std::size_t i = 0; i < kinked.v.size(); ++i) {
        out.cycle.v_mps[i] = kinked.v[i].value;
        out.cycle.v_sd_mps[i] = kinked.v[i].sigma;
    }
    out.flips = kinked.flips;
    check_bench(m, drive, out);
    return out;
}

std::vector<std::string> doubts_of(const Reduction& r) {
    std::vector<std::string> doubts;
    for (const std::string& note : r.notes)
        if (note.starts_with(alarm_note) || note.starts_with(corner_note) ||
            note.find(degraded_note) != std::string::npos || note.find(frame_rate_note) != std::string::npos)
            doubts.push_back(note);
    return doubts;
}

void set_doubts(Reduction& r) {
    for (const std::string& note : r.notes) {
        r.gain_ratio.alarm = r.gain_ratio.alarm || note.starts_with(alarm_note);
        r.degraded = r.degraded || note.find(degraded_note) != std::string::npos;
    }
}

}  // namespace shaker::reduction
