#pragma once
// The camera trigger on the DAC's second channel: one sample of 1 at the start of each exposure. Real-time.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>

namespace shaker {

/// Trigger pulses at any frame rate below the DAC's: pulse k is at the sample nearest to k rate / fps, so
/// the train does not drift against master time.
class TriggerTrain {
public:
    /// fps 0: no pulses.
    TriggerTrain(double rate_hz, double fps) noexcept : spacing_{fps > 0 ? rate_hz / fps : 0} {}

    /// Advances by `samples` samples; their pulses are not sent.
    void skip(std::int64_t samples) noexcept {
        tick_ += samples;
        if (spacing_ <= 0) return;
        pulses_ = std::max(pulses_, static_cast<std::int64_t>(static_cast<double>(tick_) / spacing_));
        while (at(pulses_) < tick_) ++pulses_;
    }
    /// Sample index of pulse k (k >= 0) in a train of `fps` at `rate_hz`.
    static std::int64_t pulse(std::int64_t k, double rate_hz, double fps) noexcept {
        return std::llround(static_cast<double>(k) * (rate_hz / fps));
    }

    /// The next samples of the channel.
    void fill(std::span<double> out) noexcept {
        for (double& sample : out) {
            const bool pulse = spacing_ > 0 && tick_ == at(pulses_);
            sample = pulse ? 1 : 0;
            pulses_ += pulse ? 1 : 0;
            ++tick_;
        }
    }

private:
    [[nodiscard]] std::int64_t at(std::int64_t k) const noexcept {
        return std::llround(static_cast<double>(k) * spacing_);
    }

    double spacing_;  // samples
    std::int64_t tick_ = 0, pulses_ = 0;
};

}  // namespace shaker
