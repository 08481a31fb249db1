#pragma once
// Volts to a converter's codes. Real-time.
#include <cstddef>
#include <cstdint>

#include "drivers/hardware/alsa_settings.hpp"
#include "drivers/time.hpp"

namespace shaker {

/// Rounds to the steps that a converter really has and lays codes into memory. One step is
/// full_scale_V / 2^(bits - 1); the largest code is one step below full scale, on both sides.
///
/// Of 32-bit samples the upper 24 bits are used: no converter resolves more (24 bits are 144 dB, the quietest
/// converters have 130), and whatever drops the low byte on the way then drops nothing.
class PcmCodec {
public:
    /// `significant_bits`: what the device says its converter has (0: not known); fewer steps are used then.
    PcmCodec(SampleFormat format, int significant_bits, double full_scale_V) noexcept;

    /// Bits of a step count: 24 or fewer.
    [[nodiscard]] int bits() const noexcept { return bits_; }
    [[nodiscard]] std::size_t bytes() const noexcept { return bytes_; }

    /// The nearest code in steps, clamped; 0 for what is not a number.
    [[nodiscard]] std::int32_t code(double volts) const noexcept { return rounded(volts, 0); }
    /// The same after triangular noise of 2 steps from peak to peak was added, which makes the error of
    /// rounding independent of the signal. The noise is a function of tick and channel alone, so that what
    /// was played can be computed again to the bit.
    [[nodiscard]] std::int32_t dithered(double volts, DacTick tick, unsigned channel) const noexcept;

    /// Writes a code's bytes().
    void put(std::byte* at, std::int32_t code) const noexcept;

private:
    [[nodiscard]] std::int32_t rounded(double volts, double noise) const noexcept;

    int bits_;
    std::size_t bytes_;
    int shift_;  // from a code to the container's integer
    double steps_per_volt_;
    double most_;  // largest code
};

}  // namespace shaker
