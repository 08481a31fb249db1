#include "daemon/frame_clock.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/trigger_train.hpp"

namespace shaker {

namespace {
constexpr std::size_t learning_frames = 64;
constexpr double jump_frames = 0.4, least_jump_s = 5e-3;  // the soonest arrival may vary by milliseconds
constexpr double patience_s = 0.5;  // longer than this machine or its network stands still
constexpr std::size_t least_patience = 100;

double frame_s(const View& view) { return view.frame_rate_hz > 0 ? 1 / view.frame_rate_hz : 1; }
}  // namespace

FrameClock::FrameClock(const View& view, double dac_rate_hz)
    : view_{view},
      dac_rate_hz_{dac_rate_hz},
      jump_{std::llround(1e9 * std::max(jump_frames * frame_s(view), least_jump_s))},
      patience_{std::max(least_patience, static_cast<std::size_t>(patience_s / frame_s(view)))},
      ticks_{1 / frame_s(view)} {
    begin_epoch(0);
}

void FrameClock::begin_epoch(std::size_t first) {
    epochs_.push_back({first, ClockTracker<CameraStampClock>{1e9}});
}

void FrameClock::add(const FrameStamp& frame) {
    if (frame.stamp)
        add_stamp(frame);
    else
        ticks_.add(frame.tick, frame.arrived);
    if (first_.size() < learning_frames) first_.push_back(frame);
    ++frames_;
}

// No frame can arrive much sooner than the soonest of many; a long row of late ones is not the network's
// doing.
void FrameClock::add_stamp(const FrameStamp& frame) {
    if (const auto map = epochs_.back().stamps.map()) {
        const auto delay = frame.arrived - map->at(*frame.stamp);
        if (delay > jump_)
            late_.push_back(frame);
        else
            late_.clear();
        const bool soonest_known = frames_ - epochs_.back().first >= 3 * patience_;  // and in the map
        if ((soonest_known && delay < -jump_) || late_.size() >= patience_) {
            begin_epoch(frames_ + 1 - std::max<std::size_t>(late_.size(), 1));
            for (const FrameStamp& late : late_) epochs_.back().stamps.add(*late.stamp, late.arrived);
            if (late_.empty()) epochs_.back().stamps.add(*frame.stamp, frame.arrived);
            late_.clear();
            return;
        }
    }
    epochs_.back().stamps.add(*frame.stamp, frame.arrived);
}

// DAC sample at which the camera's stamp says the exposure started, late by the shortest arrival.
double FrameClock::start_sample(std::size_t number, const FrameStamp& frame,
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

void FrameClock::learn_lag(const ClockMap<DacClock>& dac) {
    if (lag_known_) return;
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

MasterTime FrameClock::mid_exposure(std::size_t number, const FrameStamp& frame,
                                    const ClockMap<DacClock>& dac) {
    const double sample = start_sample(number, frame, dac);
    const double half_s = 0.5 * view_.exposure_s;
    if (!view_.dac_triggered) return master_time(sample / dac_rate_hz_ - view_.arrival_delay_s + half_s);
    learn_lag(dac);
    const auto k = std::llround((sample - lag_samples_) / (dac_rate_hz_ * frame_s(view_)));
    const auto pulse = TriggerTrain::pulse(k, dac_rate_hz_, view_.frame_rate_hz);
    return master_time(static_cast<double>(pulse) / dac_rate_hz_ + view_.trigger_delay_s + half_s);
}

}  // namespace shaker
