#pragma once
// PcmCodec: converts volts to codes of a converter. Real-time.
#include <cstddef>
#include <cstdint>

#include "drivers/hardware/alsa/settings.hpp"
#include "drivers/time.hpp"

namespace shaker::alsa {

/// Rounds to the converter's actual steps and stores codes in memory. One step is full_scale_V / 2^(bits -
/// 1); the largest code is one step below full scale, for both signs.
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

}  // namespace shaker::alsa
