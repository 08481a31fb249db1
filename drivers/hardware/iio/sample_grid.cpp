#include "drivers/hardware/iio/sample_grid.hpp"

#include <algorithm>
#include <cmath>

namespace shaker::iio {
namespace {

constexpr double learn_s = 0.25;
constexpr std::size_t learn_least = 32, learn_most = 16384;  // samples
constexpr double largest_rate_error = 0.15;
constexpr double clear_ns = 50e6, far_clear_ns = 400e6;
constexpr std::size_t clear_samples = 16;
constexpr double far_ns = 20e6;
constexpr std::size_t most_late = 4;  // consecutive samples, each by more than half a step
constexpr double clear_rise = 0.75;   // steps
constexpr double whole = 0.02;        // steps from a whole number
constexpr double never_early = 0.25;  // steps by which the line may be above the lower edge of the stamps
constexpr double most_excess = 0.1;   // steps: largest correction of the line's rate by one window
constexpr int window = 32;            // samples per update of the line
constexpr double place_gain = 0.5, rate_gain = 0.1;  // damped: the line settles within about 10 windows
constexpr double lag_drift = 500e-6;                 // largest drift of the sensor's clock against the host's

/// Wraps for invalid stamps instead of undefined behaviour.
constexpr std::int64_t minus(std::int64_t a, std::int64_t b) noexcept {
    return static_cast<std::int64_t>(static_cast<std::uint64_t>(a) - static_cast<std::uint64_t>(b));
}

std::size_t samples_to_learn(double rate_hz) {
    return std::clamp(static_cast<std::size_t>(learn_s * rate_hz), learn_least, learn_most);
}

}  // namespace

SampleGrid::SampleGrid(double rate_hz)
    : nominal_ns_{1e9 / rate_hz},
      step_ns_{nominal_ns_},
      learning_{samples_to_learn(rate_hz)},
      waiting_{std::max(4 * learning_, std::size_t{1024})},
      placed_{waiting_.capacity()} {}

double SampleGrid::above_line(std::size_t i) const noexcept {
    const std::int64_t stamp = minus(waiting_[i].stamp_ns, minus(origin_ns_, correction_ns_));
    return static_cast<double>(stamp) - (due_ns_ + step_ns_ * static_cast<double>(i));
}

double SampleGrid::lag_ns(std::size_t i) const noexcept {
    return static_cast<double>(minus(minus(waiting_[i].arrived_ns, waiting_[i].stamp_ns), correction_ns_));
}

void SampleGrid::add(const TimedSample& sample) noexcept {
    waiting_.push_back(sample);
    if (learning_ > 0) {
        if (waiting_.size() < learning_) return;
        learn_rate();
    }
    settle();
}

std::optional<PlacedSample> SampleGrid::next() noexcept {
    if (placed_.empty()) return std::nullopt;
    const PlacedSample first = placed_.front();
    placed_.pop_front();
    return first;
}

/// Median slope between the lowest stamps of short intervals: not affected by late stamps, shared stamps or a
/// loss.
void SampleGrid::learn_rate() noexcept {
    origin_ns_ = waiting_.front().stamp_ns;
    const std::size_t stretch = learning_ / lows_.size();
    for (std::size_t k = 0; k < lows_.size(); ++k) {
        lows_[k] = above_line(k * stretch);
        for (std::size_t i = 1; i < stretch; ++i) lows_[k] = std::min(lows_[k], above_line(k * stretch + i));
    }
    constexpr std::size_t apart = stretches / 4, middle = (stretches - apart) / 2;
    for (std::size_t k = 0; k + apart < lows_.size(); ++k) lows_[k] = lows_[k + apart] - lows_[k];
    std::nth_element(lows_.begin(), lows_.begin() + middle, lows_.end() - apart);
    const double excess = lows_[middle] / static_cast<double>(apart * stretch);
    if (std::abs(excess / nominal_ns_) <= largest_rate_error) step_ns_ += excess;
    double lowest = 0;
    for (std::size_t i = 0; i < learn_least; ++i) lowest = std::min(lowest, above_line(i));
    if (lowest > -far_ns) due_ns_ = lowest;
    learning_ = 0;
}

void SampleGrid::settle() noexcept {
    while (held_ < waiting_.size()) {
        const double above = above_line(held_);
        const bool off = std::abs(above) > step_ns_ / 2;
        if (held_ == 0 && !off) {
            place_first(0);
        } else if (held_ == 0 || (off && (above > 0) == held_above_)) {
            held_above_ = above > 0;
            held_lowest_ns_ = held_ == 0 ? above : std::min(held_lowest_ns_, above);
            ++held_;
            if (clear()) decide();
        } else {
            for (; held_ > 0; --held_) place_first(0);
        }
    }
}

bool SampleGrid::clear() const noexcept {
    if (waiting_.full() && held_ == waiting_.size()) return true;
    const auto span = static_cast<double>(minus(waiting_[held_ - 1].stamp_ns, waiting_.front().stamp_ns));
    const bool far = std::abs(held_lowest_ns_) > far_ns;
    return held_ >= clear_samples && std::abs(span) >= (far ? far_clear_ns : clear_ns);
}

/// Number of held samples before the loss: their delay is random, not whole steps. All samples after the loss
/// are higher above the line by the missing time.
std::size_t SampleGrid::late_before_loss() const noexcept {
    std::size_t late = 0;
    const double steps = held_lowest_ns_ / step_ns_;
    if (steps > 0.5 && std::abs(steps - std::round(steps)) < whole) return 0;
    double lowest = above_line(held_ - 1);
    for (std::size_t i = held_ - 1; i > 0; --i) {
        lowest = std::min(lowest, above_line(i));
        if (i <= most_late && lowest > held_lowest_ns_ + clear_rise * step_ns_) late = i;
    }
    return late;
}

void SampleGrid::decide() noexcept {
    if (held_lowest_ns_ > 0) {
        if (const std::size_t late = late_before_loss(); late > 0) {
            held_ = 0;
            for (std::size_t i = 0; i < late; ++i) place_first(0);
            return;
        }
    }
    double lag = lag_ns(0);
    for (std::size_t i = 1; i < held_; ++i) lag = std::min(lag, lag_ns(i));
    held_ = 0;
    const double above = held_lowest_ns_, lag_change = lag_known_ ? lag - least_lag_ns_ : 0;
    std::int64_t lost = 0;
    if (above < -far_ns || (above > far_ns && lag_change < -above / 2)) {
        lost = follow_clock(lag_known_ ? lag_change : -above);
    } else if (above < 0) {
        due_ns_ += above;  // the line was too high
    } else {
        lost = static_cast<std::int64_t>(std::floor(above / step_ns_ + never_early));
        due_ns_ += step_ns_ * static_cast<double>(lost);
    }
    place_first(lost);
}

/// The lag of the stamps behind the host minus the step of the sensor's clock is the delay of the samples.
std::int64_t SampleGrid::follow_clock(double lag_change_ns) noexcept {
    ++clock_steps_;
    const double late = held_lowest_ns_ + lag_change_ns;
    const std::int64_t lost = late > far_ns ? std::llround(late / step_ns_) : 0;
    correction_ns_ += std::llround(step_ns_ * static_cast<double>(lost) - held_lowest_ns_);
    due_ns_ += step_ns_ * static_cast<double>(lost);
    return lost;
}

void SampleGrid::place_first(std::int64_t lost) noexcept {
    const double above = above_line(0), lag = lag_ns(0);
    PlacedSample placed{waiting_.front(), tick_ + lost, lost};
    // A stamp below the line is a short slip of the clock; the line is more accurate.
    if (above < -step_ns_ / 2)
        placed.sample.stamp_ns = origin_ns_ + std::llround(due_ns_);
    else
        placed.sample.stamp_ns += correction_ns_;
    placed_.push_back(placed);
    waiting_.pop_front();
    tick_ += lost + 1;
    due_ns_ += step_ns_;
    follow(above, lag);
}

void SampleGrid::follow(double above_ns, double lag_ns) noexcept {
    if (std::abs(above_ns) <= step_ns_ / 2) {
        lowest_ns_ = on_line_ == 0 ? above_ns : std::min(lowest_ns_, above_ns);
        ++on_line_;
        least_lag_ns_ = lag_known_ ? std::min(least_lag_ns_ + lag_drift * step_ns_, lag_ns) : lag_ns;
        lag_known_ = true;
    }
    if (++window_ < window) return;
    if (on_line_ > 0) {
        due_ns_ += place_gain * lowest_ns_;
        const double excess = std::clamp(lowest_ns_, -most_excess * step_ns_, most_excess * step_ns_);
        step_ns_ = std::clamp(step_ns_ + rate_gain * excess / window, nominal_ns_ * (1 - largest_rate_error),
                              nominal_ns_ * (1 + largest_rate_error));
    }
    window_ = on_line_ = 0;
}

}  // namespace shaker::iio
