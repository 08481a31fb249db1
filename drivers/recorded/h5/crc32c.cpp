#include "drivers/recorded/h5/crc32c.hpp"

#include <bit>
#include <boost/crc.hpp>
#include <cstring>

#if defined(__x86_64__)
#include <nmmintrin.h>
#endif

namespace shaker::h5 {

namespace {

std::uint32_t plain(std::span<const std::byte> bytes, std::uint32_t before) noexcept {
    // The library takes its remainder before reflection and final complement.
    const auto reflected = [](std::uint32_t x) {
        std::uint32_t y = 0;
        for (int i = 0; i < 32; ++i)
            y |= ((x >> static_cast<unsigned>(i)) & 1U) << static_cast<unsigned>(31 - i);
        return y;
    };
    boost::crc_optimal<32, 0x1EDC6F41, 0, 0xFFFFFFFF, true, true> crc{reflected(~before)};
    crc.process_bytes(bytes.data(), bytes.size());
    return crc.checksum();
}

#if defined(__x86_64__)
// The processor's CRC instruction, 20 times faster.
__attribute__((target("sse4.2"))) std::uint32_t fast(std::span<const std::byte> bytes,
                                                     std::uint32_t before) noexcept {
    std::uint64_t crc = ~before;
    const std::byte* at = bytes.data();
    std::size_t left = bytes.size();
    for (; left >= 8; left -= 8, at += 8) {
        std::uint64_t word = 0;
        std::memcpy(&word, at, 8);
        crc = _mm_crc32_u64(crc, word);
    }
    auto low = static_cast<std::uint32_t>(crc);
    for (; left > 0; --left, ++at) low = _mm_crc32_u8(low, std::to_integer<std::uint8_t>(*at));
    return ~low;
}
#endif

}  // namespace

std::uint32_t crc32c(std::span<const std::byte> bytes, std::uint32_t before) noexcept {
#if defined(__x86_64__)
    if (__builtin_cpu_supports("sse4.2")) return fast(bytes, before);
#endif
    return plain(bytes, before);
}

}  // namespace shaker::h5
