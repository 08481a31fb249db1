#pragma once
// What goes to the converter: both channels of a block as bytes, and the ramp to zero that lies behind it.
// Real-time.
#include <cstdint>
#include <span>
#include <vector>

#include "drivers/hardware/alsa_settings.hpp"
#include "drivers/hardware/pcm_codec.hpp"
#include "drivers/time.hpp"
#include "drivers/turns.hpp"

namespace shaker {

/// Drive on channel 0, trigger pulses or tone on channel 1, zero on all further channels.
class OutputFrames {
public:
    /// Memory for blocks of up to `most_frames` with their ramp is taken here.
    OutputFrames(const AlsaSettings& settings, const PcmCodec& codec, std::size_t channels,
                 std::size_t most_frames);

    [[nodiscard]] std::size_t frame_bytes() const noexcept { return channels_ * codec_.bytes(); }
    [[nodiscard]] std::size_t ramp_frames() const noexcept { return ramp_.size(); }

    /// A block that begins at `first`, then the ramp: a raised cosine on the block's last value, which goes
    /// on at the block's last slope and loses it within a millisecond. Neither value nor slope jumps and the
    /// ramp ends at exact zero; the second channel is zero in it. The trigger has one value a sample, 1 where
    /// an exposure begins.
    std::span<const std::byte> block(std::span<const double> volts, std::span<const double> trigger,
                                     DacTick first) noexcept;
    /// The ramp alone, from where the last block ended.
    std::span<const std::byte> ramp() noexcept;
    /// Nothing was played for a while: the next block's ramp knows no slope from before, no pulse goes on.
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
    Turns tone_;                       // a sample
    double decay_;                     // of the slope, a sample
    std::int64_t pulse_left_ = 0;      // samples
    double last_V_ = 0, slope_V_ = 0;  // at the end of the last block; slope a sample
    std::vector<double> ramp_;         // its shape, 1 to 0
    std::vector<std::byte> bytes_;
};

}  // namespace shaker
