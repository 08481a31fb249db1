#pragma once
// The camera trigger on the DAC's second channel: one sample of 1 at the start of each exposure. Real-time.
#include <cmath>
#include <cstdint>
#include <span>

namespace shaker {

/// Pulses at a frame rate that need not divide the DAC's: pulse k is at the sample nearest to k rate / fps,
/// so the train never drifts against the master time.
class TriggerTrain {
public:
    /// fps 0: no pulses.
    TriggerTrain(double rate_hz, double fps) noexcept : spacing_{fps > 0 ? rate_hz / fps : 0} {}

    /// The next samples of the channel.
    void fill(std::span<double> out) noexcept {
        for (double& sample : out) {
            const bool pulse = spacing_ > 0 && tick_ == std::llround(static_cast<double>(pulses_) * spacing_);
            sample = pulse ? 1 : 0;
            pulses_ += pulse ? 1 : 0;
            ++tick_;
        }
    }

private:
    double spacing_;  // samples
    std::int64_t tick_ = 0, pulses_ = 0;
};

}  // namespace shaker
