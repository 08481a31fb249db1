#include "daemon/control/period_windows.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "drivers/time.hpp"

namespace shaker::control {

namespace {

constexpr std::size_t kept = 512;

// Integral of the ramp's weight (raised cosine, 0 before, 1 after) from its start to `t`; `length` in s.
double risen(double t, double length) {
    if (t <= 0) return 0;
    if (t >= length) return t - 0.5 * length;
    return 0.5 * t - 0.5 * length / std::numbers::pi * std::sin(std::numbers::pi * t / length);
}

constexpr double most_samples = 1.2;  // times the nominal number of samples per window

}  // namespace

DriveHistory::DriveHistory(double rate_hz, double frequency) : rate_hz_{rate_hz} {
    changes_.push_back({.volts = {}, .frequency = frequency});
}

void DriveHistory::add(const DriveChange& change) {
    if (change.taken_back > 0)
        while (changes_.size() > 1 && changes_.back().begin_s >= counted_s(change.first, rate_hz_))
            changes_.pop_back();
    const Change before = changes_.back();
    Change c{.volts = change.command.volts,
             .frequency = change.command.frequency,
             .sequence = change.command.sequence,
             .begin_s = counted_s(change.first, rate_hz_),
             .end_s = counted_s(DacTick{change.first.n + change.ramp}, rate_hz_)};
    if (change.stop > 0) {  // the phase continues during the stop
        c.volts = {};
        c.frequency = before.frequency;
        c.end_s = counted_s(DacTick{change.first.n + change.stop}, rate_hz_);
        c.begin_turns = turns(c.begin_s);
        c.end_turns = turns(c.end_s);
        append(c);
        return;
    }
    // A change begins at the first sample of a turn; its phase is the fraction of the turn at that
    // sample.
    const double expected = turns(c.begin_s);
    const double part = static_cast<double>(static_cast<long double>(change.phase) * 0x1p-128L);
    c.begin_turns = std::round(expected - part) + part;
    const double length = c.end_s - c.begin_s, step = c.frequency - before.frequency;
    // Each sample uses the step at its beginning: half a step of the rise less than the integral.
    c.end_turns = c.begin_turns + before.frequency * length + step * risen(length, length) -
                  (length > 0 ? 0.5 * step / rate_hz_ : 0);
    append(c);
}

void DriveHistory::append(const Change& c) {
    changes_.push_back(c);
    if (changes_.size() > kept) changes_.pop_front();
}

double DriveHistory::turns(double at_s) const {
    auto c = changes_.rbegin();
    while (std::next(c) != changes_.rend() && at_s < c->begin_s) ++c;
    if (at_s >= c->end_s || std::next(c) == changes_.rend())
        return c->end_turns + c->frequency * (at_s - c->end_s);
    const Change& before = *std::next(c);
    const double t = at_s - c->begin_s;
    return c->begin_turns + before.frequency * t +
           (c->frequency - before.frequency) * risen(t, c->end_s - c->begin_s);
}

Harmonics<Voltage> DriveHistory::mean(double from_s, double to_s) const {
    Harmonics<Voltage> sum = changes_.front().volts;
    for (std::size_t i = 1; i < changes_.size(); ++i) {
        const Change& c = changes_[i];
        if (c.begin_s >= to_s) break;
        const double length = c.end_s - c.begin_s;
        const double weight =
            (risen(to_s - c.begin_s, length) - risen(from_s - c.begin_s, length)) / (to_s - from_s);
        for (std::size_t q = 0; q < max_harmonics; ++q)
            sum.a[q] += weight * (c.volts.a[q] - changes_[i - 1].volts.a[q]);
    }
    return sum;
}

bool DriveHistory::steady(double from_s, double to_s) const {
    const double sample = 1 / rate_hz_;  // resolution of the times of samples
    return std::ranges::none_of(
        changes_, [&](const Change& c) { return c.begin_s < to_s - sample && c.end_s > from_s + sample; });
}

PeriodWindows::PeriodWindows(double dac_rate_hz, const AccelerometerInfo& accelerometer, double frequency,
                             int harmonics, double line_hz)
    : accelerometer_{accelerometer},
      harmonics_{harmonics},
      line_hz_{line_hz},
      dac_rate_hz_{dac_rate_hz},
      history_{dac_rate_hz, frequency},
      estimator_{estimator_settings(frequency, {})},
      mains_{accelerometer.rate_hz} {}

EstimatorSettings PeriodWindows::estimator_settings(double frequency,
                                                    const std::array<double, 3>& before) const {
    const double ratio = line_hz_ / frequency;
    const int periods = periods_to_tell(ratio, harmonics_);
    EstimatorSettings s;
    s.harmonics = harmonics_;
    s.axis = accelerometer_.shaker_axis;
    s.before = before;
    s.periods = std::max(1, periods);
    s.line = periods > 0 ? ratio : 0;
    s.samples = static_cast<int>(most_samples * s.periods * accelerometer_.rate_hz / frequency) + 2;
    return s;
}

void PeriodWindows::add(const DriveChange& change) {
    if (change.command.frequency != history_.frequency()) {
        estimator_ = HarmonicEstimator{estimator_settings(change.command.frequency, estimator_.direction())};
        tuned_from_s_ = counted_s(DacTick{change.first.n + change.ramp}, dac_rate_hz_);
    }
    history_.add(change);
}

void PeriodWindows::fit_line(double hz) {
    line_hz_ = hz;
    estimator_ = HarmonicEstimator{estimator_settings(history_.frequency(), estimator_.direction())};
}

// The response of the settings; another one is known after a measurement only.
void PeriodWindows::take_off_response(PeriodEstimate& e) const {
    if (accelerometer_.response.none()) return;
    for (int q = 1; q <= harmonics_; ++q) {
        const std::complex<double> response = accelerometer_.response.at(q * history_.frequency());
        for (Harmonics<Acceleration>* h : {&e.along, &e.across[0], &e.across[1]}) h->at(q) /= response;
    }
}

std::vector<PeriodWindows::Window> PeriodWindows::add(const AccelBlock& block,
                                                      const calibration::Timebase& timebase) {
    std::vector<Window> windows;
    if (!timebase.ready()) return windows;
    until_s_ = seconds(timebase.at(AccelTick{block.first.n + block.size}));
    for (int i = 0; i < block.size; ++i) {
        const double at_s = seconds(timebase.at(AccelTick{block.first.n + i}));
        if (at_s < tuned_from_s_) continue;
        const auto a = accelerometer_.acceleration(block.counts[static_cast<std::size_t>(i)]);
        if (history_.sequence() == 0) mains_.add(at_s, a);
        const auto done = estimator_.add(history_.turns(at_s), a);
        if (!done) continue;
        axis_ = done->axis;
        mean_ = done->mean;
        Window w{.estimate = *done, .motion = {}};
        take_off_response(w.estimate);
        w.to_s = at_s;
        w.from_s = at_s - done->periods / history_.frequency();
        w.sequence = history_.sequence();
        w.motion = {w.estimate.along, done->sd, history_.mean(w.from_s, w.to_s),
                    history_.steady(w.from_s, w.to_s) && history_.in_force_s() <= w.from_s};
        windows.push_back(w);
    }
    return windows;
}

}  // namespace shaker::control
