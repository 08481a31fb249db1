#include "calibration/clocks/exposure_clock.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/time.hpp"
#include "drivers/trigger_train.hpp"

namespace shaker::calibration {

namespace {
constexpr std::size_t learning_frames = 64;
// A jump is a deviation of at least 0.4 frames and 5 ms; the shortest delay may vary by milliseconds.
constexpr double jump_frames = 0.4, least_jump_s = 5e-3;
constexpr double odd_step = 0.02;   // tolerance of a step of the stamps, share of a frame
constexpr double patience_s = 0.5;  // longer than pauses of computer or network
constexpr std::size_t least_patience = 100;

double frame_s(const View& view) { return view.frame_rate_hz > 0 ? 1 / view.frame_rate_hz : 1; }
}  // namespace

ExposureClock::ExposureClock(const View& view, double dac_rate_hz)
    : view_{view},
      dac_rate_hz_{dac_rate_hz},
      jump_{std::llround(1e9 * std::max(jump_frames * frame_s(view), least_jump_s))},
      patience_{std::max(least_patience, static_cast<std::size_t>(patience_s / frame_s(view)))},
      ticks_{view.frame_rate_hz > 0 ? view.frame_rate_hz : 1} {
    begin_epoch(0);
}

void ExposureClock::begin_epoch(std::size_t first) {
    epochs_.push_back({first, ClockTracker<CameraStampClock>{1e9}});
}

void ExposureClock::add(const FrameStamp& frame) {
    if (frame.stamp) add_stamp(frame);
    ticks_.add(frame.tick, frame.arrived);
    if (first_.size() < learning_frames) first_.push_back(frame);
    ++frames_;
}

// A jump needs two pieces of evidence. First, a step of the stamps disagrees with the count of exposures; a
// missed pulse alone can cause this too. Second, frames then arrive impossibly early, or all of them arrive
// late for a long time; a pause of the computer alone can cause late frames too.
void ExposureClock::add_stamp(const FrameStamp& frame) {
    const double period_ns = 1e9 * frame_s(view_);
    if (before_) {
        const double step_ns = static_cast<double>(frame.stamp->n - before_->stamp->n);
        const double counted_ns = period_ns * static_cast<double>(frame.tick.n - before_->tick.n);
        suspect_ = suspect_ || std::abs(step_ns - counted_ns) > odd_step * period_ns;
    }
    before_ = frame;
    if (const auto map = epochs_.back().stamps.map(); map && suspect_) {
        const auto delay = frame.arrived - map->at(*frame.stamp);
        if (delay > jump_) late_.push_back(frame);
        if (delay < -jump_ || late_.size() >= patience_) {
            if (late_.empty()) late_.push_back(frame);
            begin_epoch(frames_ + 1 - late_.size());
            for (const FrameStamp& late : late_) epochs_.back().stamps.add(*late.stamp, late.arrived);
            forget_suspicion();
            return;
        }
        if (delay <= jump_) forget_suspicion();
    }
    epochs_.back().stamps.add(*frame.stamp, frame.arrived);
}

void ExposureClock::forget_suspicion() {
    suspect_ = false;
    late_.clear();
}

// DAC sample of the start of the exposure by the camera's stamp. It contains the shortest delay of arrival.
double ExposureClock::start_sample(std::size_t number, const FrameStamp& frame,
                                   const ClockMap<DacClock>& dac) const {
    HostTime start = frame.arrived;
    if (frame.stamp) {
        const auto after = std::ranges::upper_bound(epochs_, number, {}, &Epoch::first);
        start = std::prev(after)->stamps.map()->at(*frame.stamp);
    } else if (ticks_.map()) {
        start = ticks_.map()->at(frame.tick);
    }
    const TickInstant<DacClock> k = dac.at(start);
    return static_cast<double>(k.tick.n) + k.fraction;
}

void ExposureClock::learn_lag(const ClockMap<DacClock>& dac) {
    if (lag_known_ || first_.empty()) return;
    std::vector<double> lags;
    for (std::size_t i = 0; i < first_.size(); ++i) {
        const auto pulse = TriggerTrain::pulse(first_[i].tick.n, dac_rate_hz_, view_.frame_rate_hz);
        lags.push_back(start_sample(i, first_[i], dac) - static_cast<double>(pulse));
    }
    const auto middle = lags.begin() + static_cast<std::ptrdiff_t>(lags.size() / 2);
    std::ranges::nth_element(lags, middle);
    lag_samples_ = *middle;
    lag_known_ = first_.size() == learning_frames;
}

MasterTime ExposureClock::mid_exposure(std::size_t number, const FrameStamp& frame,
                                       const ClockMap<DacClock>& dac) {
    const double sample = start_sample(number, frame, dac);
    const double half_s = 0.5 * view_.exposure_s;
    if (!view_.dac_triggered) return master_time(sample / dac_rate_hz_ - view_.arrival_delay_s + half_s);
    learn_lag(dac);
    const auto k = std::llround((sample - lag_samples_) / (dac_rate_hz_ * frame_s(view_)));
    const auto pulse = TriggerTrain::pulse(k, dac_rate_hz_, view_.frame_rate_hz);
    return master_time(duration_s(pulse, dac_rate_hz_) + view_.trigger_delay_s + half_s);
}

}  // namespace shaker::calibration
