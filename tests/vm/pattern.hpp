#pragma once
// Test pattern of the virtual machine's jobs. Samples identify their own position, so any part of a
// recording can be located in the played pattern, to the bit.
#include <cstdint>
#include <string>
#include <vector>

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

/// The first channel of a file with two channels: WAV or raw samples, little-endian. Codes of 16 bits are in
/// two bytes, codes of 24 bits in the upper three of four bytes. Throws InputError when it cannot be read.
std::vector<std::int32_t> read_first_channel(const std::string& path, int bits);

/// Where the pattern's first `frames` samples are in a recording.
struct PatternFound {
    std::int64_t exact = 0;     // samples equal to the pattern, in runs of four or more, in order
    std::int64_t pieces = 0;    // number of contiguous pieces
    std::int64_t longest = 0;   // length of the longest piece
    std::int64_t skipped = 0;   // samples of the pattern missing between two pieces
    std::int64_t repeated = 0;  // samples of the pattern that appear again, out of order
    std::int64_t foreign = 0;   // samples that are neither the pattern nor zero
};

/// Searches the first channel of a recording. Throws InputError when the file cannot be read.
PatternFound find_pattern(const std::string& path, int bits, std::int64_t frames);

}  // namespace shaker
