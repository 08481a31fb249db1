#pragma once
// Bytes for the converter: both channels of a block, and the ramp to zero that follows it. Real-time.
#include <cstdint>
#include <span>
#include <vector>

#include "drivers/hardware/alsa/pcm_codec.hpp"
#include "drivers/hardware/alsa/settings.hpp"
#include "drivers/time.hpp"
#include "drivers/turns.hpp"

namespace shaker::alsa {

/// Drive on channel 0, trigger pulses or tone on channel 1, zero on all further channels.
class OutputFrames {
public:
    /// Allocates memory for blocks of up to `most_frames` and their ramp.
    OutputFrames(const AlsaSettings& settings, const PcmCodec& codec, std::size_t channels,
                 std::size_t most_frames);

    [[nodiscard]] std::size_t frame_bytes() const noexcept { return channels_ * codec_.bytes(); }
    [[nodiscard]] std::size_t ramp_frames() const noexcept { return ramp_.size(); }

    /// A block that begins at `first`, then the ramp: a raised cosine times the block's last value, which
    /// continues at the block's last slope; the slope decays within a millisecond. Neither value nor slope
    /// jumps, and the ramp ends at exactly zero. The second channel is zero in the ramp. `trigger` has one
    /// value per sample: 1 at the start of an exposure, else 0.
    std::span<const std::byte> block(std::span<const double> volts, std::span<const double> trigger,
                                     DacTick first) noexcept;
    /// The ramp alone, from the end of the last block.
    std::span<const std::byte> ramp() noexcept;
    /// Call after an interruption: the next ramp ignores the old slope, and a started pulse does not
    /// continue.
    void restart() noexcept;

private:
    void put(std::size_t frame, std::int32_t drive, std::int32_t second) noexcept;
    [[nodiscard]] std::int32_t second(double trigger, DacTick tick) noexcept;
    void put_ramp(std::size_t at) noexcept;

    PcmCodec codec_;
    std::size_t channels_;
    SecondChannel kind_;
    bool dither_;
    double level_V_;  // of the second channel
    std::int64_t pulse_samples_;
    Turns tone_;                       // turns per sample
    double decay_;                     // factor of the slope per sample
    std::int64_t pulse_left_ = 0;      // samples
    double last_V_ = 0, slope_V_ = 0;  // at the end of the last block; slope in V per sample
    std::vector<double> ramp_;         // shape, 1 to 0
    std::vector<std::byte> bytes_;
};

}  // namespace shaker::alsa
