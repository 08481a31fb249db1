#pragma once
// Phase as a 128-bit fraction of a turn: sums wrap at whole turns and lose nothing. Real-time.
#include <cstdint>

namespace shaker {

/// In units of 2^-128 turn.
__extension__ typedef unsigned __int128 Turns;

/// The upper word, in units of 2^-64 turn.
constexpr std::uint64_t high_word(Turns t) noexcept { return static_cast<std::uint64_t>(t >> 64); }
/// The lower word, in units of 2^-128 turn.
constexpr std::uint64_t low_word(Turns t) noexcept { return static_cast<std::uint64_t>(t); }
constexpr Turns turns_of(std::uint64_t high, std::uint64_t low) noexcept { return (Turns{high} << 64) | low; }

/// frequency / rate_hz, rounded up to a whole unit. Requires 0 <= frequency < rate_hz; other arguments
/// give a meaningless result.
constexpr Turns turns_per_sample(double frequency, double rate_hz) noexcept {
    // Long division, bit by bit. The remainder stays below the divisor and is an exact double: half
    // the rate is subtracted only from numbers up to twice as large.
    const double half = rate_hz / 2;
    double remainder = frequency;
    Turns quotient = 0;
    for (int bit = 0; bit < 128; ++bit) {
        const bool one = remainder >= half;
        if (one) remainder -= half;
        remainder *= 2;
        quotient = (quotient << 1) | Turns{one};
    }
    return quotient + (remainder > 0);
}

}  // namespace shaker
