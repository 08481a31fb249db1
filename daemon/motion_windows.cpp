#include "daemon/motion_windows.hpp"

#include <algorithm>

namespace shaker {

namespace {
constexpr double most_samples = 1.2;  // of the nominal number a window
}

MotionWindows::MotionWindows(double dac_rate_hz, const AccelerometerInfo& accelerometer, double frequency,
                             int harmonics, double line_hz)
    : accelerometer_{accelerometer},
      harmonics_{harmonics},
      line_hz_{line_hz},
      clock_{dac_rate_hz, accelerometer.rate_hz},
      history_{dac_rate_hz, frequency},
      estimator_{estimator_settings(frequency)} {}

EstimatorSettings MotionWindows::estimator_settings(double frequency) const {
    const double ratio = line_hz_ / frequency;
    const int periods = periods_to_tell(ratio, harmonics_);
    EstimatorSettings s;
    s.harmonics = harmonics_;
    s.axis = accelerometer_.shaker_axis;
    s.before = axis_;
    s.periods = std::max(1, periods);
    s.line = periods > 0 ? ratio : 0;
    s.samples = static_cast<int>(most_samples * s.periods * accelerometer_.rate_hz / frequency) + 2;
    return s;
}

void MotionWindows::add(const DriveChange& change) {
    if (change.command.frequency != history_.frequency()) {
        estimator_ = HarmonicEstimator{estimator_settings(change.command.frequency)};
        tuned_from_s_ = static_cast<double>(change.first.n + change.ramp) / clock_.dac_rate_hz();
    }
    history_.add(change);
}

std::vector<MotionWindows::Window> MotionWindows::add(const AccelBlock& block) {
    std::vector<Window> windows;
    clock_.add(block);
    if (!clock_.ready()) return windows;
    until_s_ = seconds(clock_.master({block.first.n + block.size}));
    for (int i = 0; i < block.size; ++i) {
        const double at_s = seconds(clock_.master({block.first.n + i}));
        if (at_s < tuned_from_s_) continue;
        const auto a = accelerometer_.acceleration(block.counts[static_cast<std::size_t>(i)]);
        const auto done = estimator_.add(history_.turns(at_s), a);
        if (!done) continue;
        axis_ = done->axis;
        mean_ = done->mean;
        Window w{.estimate = *done, .motion = {}};
        w.to_s = at_s;
        w.from_s = at_s - done->periods / history_.frequency();
        w.sequence = history_.sequence();
        w.motion = {done->along, done->sd, history_.mean(w.from_s, w.to_s),
                    history_.steady(w.from_s, w.to_s) && history_.in_force_s() <= w.from_s};
        windows.push_back(w);
    }
    return windows;
}

}  // namespace shaker
