#pragma once
// What the virtual machine's jobs play: samples that tell which they are, so that any stretch of a recording
// can be placed in what was played, to the bit.
#include <cstdint>
#include <string>

namespace shaker {

/// Sample `frame` of the pattern as a code of `bits` bits, never full scale: a hash of the frame.
constexpr std::int32_t pattern_code(std::int64_t frame, int bits) noexcept {
    auto x = static_cast<std::uint64_t>(frame) + 0x9E3779B97F4A7C15U;  // splitmix64, Steele et al. 2014
    x = (x ^ (x >> 30U)) * 0xBF58476D1CE4E5B9U;
    x = (x ^ (x >> 27U)) * 0x94D049BB133111EBU;
    x ^= x >> 31U;
    const auto code = static_cast<std::int32_t>(static_cast<std::uint32_t>(x));
    return (code >> (32 - bits)) / 2;
}

/// Where the pattern's first `frames` samples are in a recording.
struct PatternFound {
    std::int64_t exact = 0;     // samples equal to the pattern, in runs of four or more, in order
    std::int64_t pieces = 0;    // unbroken stretches of them
    std::int64_t longest = 0;   // of these
    std::int64_t skipped = 0;   // samples of the pattern left out between two pieces
    std::int64_t repeated = 0;  // samples of the pattern that come again, out of order
    std::int64_t foreign = 0;   // samples that are neither the pattern nor zero
};

/// Looks in the first channel of a file of two: a WAV, or samples alone, little endian. Codes of 16 bits are
/// in two bytes; of 24 bits in the upper three of four bytes, the lowest zero. Throws InputError when the
/// file cannot be read.
PatternFound find_pattern(const std::string& path, int bits, std::int64_t frames);

}  // namespace shaker
