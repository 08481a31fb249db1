#include "daemon/control/period_windows.hpp"

#include <algorithm>

#include "drivers/time.hpp"

namespace shaker::control {

namespace {
constexpr double most_samples = 1.2;  // times the nominal number of samples per window
}

PeriodWindows::PeriodWindows(double dac_rate_hz, const AccelerometerInfo& accelerometer, double frequency,
                             int harmonics, double line_hz)
    : accelerometer_{accelerometer},
      harmonics_{harmonics},
      line_hz_{line_hz},
      dac_rate_hz_{dac_rate_hz},
      history_{dac_rate_hz, frequency},
      estimator_{estimator_settings(frequency, {})} {}

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

std::vector<PeriodWindows::Window> PeriodWindows::add(const AccelBlock& block,
                                                      const calibration::Timebase& timebase) {
    std::vector<Window> windows;
    if (!timebase.ready()) return windows;
    until_s_ = seconds(timebase.at(AccelTick{block.first.n + block.size}));
    for (int i = 0; i < block.size; ++i) {
        const double at_s = seconds(timebase.at(AccelTick{block.first.n + i}));
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

}  // namespace shaker::control
