#pragma once
// Bytes for the converter: the channels of a block, and the ramp to zero that follows it. Real-time.
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "drivers/hardware/alsa/settings.hpp"
#include "drivers/synthesiser.hpp"
#include "drivers/time.hpp"

namespace shaker::alsa {

/// Converts volts to codes of a converter. Real-time. Rounds to the converter's actual steps and stores codes
/// in memory. One step is full_scale_V / 2^(bits - 1); the largest code is one step below full scale, for
/// both signs.
///
/// Of 32-bit samples the upper 24 bits are used: no converter resolves more (24 bits are 144 dB, the quietest
/// converters have 130), and a device that drops the low byte then loses nothing.
class PcmCodec {
public:
    /// significant_bits: as reported by the device (0: unknown); fewer bits give larger steps.
    PcmCodec(SampleFormat format, int significant_bits, double full_scale_V) noexcept;

    /// Number of bits of a step count, at most 24.
    [[nodiscard]] int bits() const noexcept { return bits_; }
    [[nodiscard]] std::size_t bytes() const noexcept { return bytes_; }

    /// The nearest code, clamped; 0 for NaN.
    [[nodiscard]] std::int32_t code(double volts) const noexcept { return rounded(volts, 0); }
    /// The same with triangular dither of 2 steps peak to peak, which makes the rounding error independent of
    /// the signal. The dither depends only on tick and channel, so the played samples can be recomputed to
    /// the bit.
    [[nodiscard]] std::int32_t dithered(double volts, DacTick tick, unsigned channel) const noexcept;

    /// Writes bytes() bytes of a code.
    void put(std::byte* at, std::int32_t code) const noexcept;

private:
    [[nodiscard]] std::int32_t rounded(double volts, double noise) const noexcept;

    int bits_;
    std::size_t bytes_;
    int shift_;  // left shift from a code to the container's integer
    double steps_per_volt_;
    double most_;  // largest code
};

/// Drive, trigger pulses or tone, and the enable tone if there is one, on their channels; zero on all others.
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
    /// value per sample: 1 at the start of an exposure, else 0. enabled: the enable tone is present in the
    /// block and until the end of the ramp.
    std::span<const std::byte> block(std::span<const double> volts, std::span<const double> trigger,
                                     DacTick first, bool enabled = false) noexcept;
    /// The ramp alone, from the end of the last block, and silence behind it: at most the length of the
    /// buffer together.
    std::span<const std::byte> ramp(std::int64_t silence = 0) noexcept;
    /// Largest number of samples for go_back().
    [[nodiscard]] std::int64_t most_back() const noexcept;
    /// Goes back by `samples`, 0..most_back(): the next block or ramp follows the sample before them.
    void go_back(std::int64_t samples) noexcept;
    /// Call after an interruption: the next ramp ignores the old slope and has no enable tone, and a started
    /// pulse does not continue.
    void restart() noexcept;

private:
    /// What a ramp from a sample, and the other channels after it, depend on.
    struct End {
        double volts = 0, slope = 0;  // V, V per sample
        std::int64_t pulse_left = 0;  // samples
        bool enabled = false;
    };
    void put(std::size_t frame, std::int32_t drive, std::int32_t second, std::int32_t enable) noexcept;
    [[nodiscard]] std::int32_t tone(Turns step, double level_V, DacTick tick, unsigned channel) noexcept;
    [[nodiscard]] std::int32_t enable_tone(DacTick tick) noexcept;
    [[nodiscard]] std::int32_t second(double trigger, DacTick tick) noexcept;
    void put_ramp(std::size_t at) noexcept;

    PcmCodec codec_;
    std::size_t channels_;
    SecondChannel kind_;
    bool dither_;
    double level_V_;  // of the second channel
    std::int64_t pulse_samples_;
    Turns tone_;                                    // turns per sample
    std::size_t drive_at_, second_at_, enable_at_;  // channels from 0
    bool enable_;                                   // there is an enable tone
    double enable_level_V_;
    Turns enable_tone_;                 // turns per sample
    DacTick tick_{};                    // after the last sample
    double decay_;                      // factor of the slope per sample
    End end_;                           // at the last sample
    std::vector<End> ends_;             // at the newest samples, a ring
    std::size_t next_ = 0, known_ = 0;  // place of the next sample in the ring; samples in it
    std::vector<double> ramp_;          // shape, 1 to 0
    std::vector<std::byte> bytes_;
};

}  // namespace shaker::alsa
