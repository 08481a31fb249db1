#pragma once
// LineMemory: mapped file shared by a mock line input's owner and the PCM plug-in. Clock, faults and samples.
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace shaker::mock {

struct LineMemory {
    static constexpr std::uint64_t version = 0x73686b6d6f636b11;
    static constexpr std::size_t channels = 2, held = std::size_t{1} << 18U;  // samples
    using Frame = std::array<std::atomic<std::int32_t>, channels>;            // left-justified codes

    std::atomic<std::uint64_t> ready;  // == version when everything else is initialised
    double rate_hz;                    // true rate by CLOCK_MONOTONIC; its nominal one is `nominal_hz`
    double nominal_hz;
    std::int64_t epoch_ns;  // CLOCK_MONOTONIC of sample 0
    std::atomic<bool> overrun, unplugged;
    std::atomic<std::int64_t> recorded;  // samples so far
    std::array<Frame, held> frames;

    [[nodiscard]] Frame& frame(std::int64_t index) noexcept {
        return frames[static_cast<std::size_t>(index) % held];
    }
    /// Samples that have been converted at a time and are recorded.
    [[nodiscard]] std::int64_t due(std::int64_t monotonic_ns) const noexcept {
        const double n = 1e-9 * rate_hz * static_cast<double>(monotonic_ns - epoch_ns);
        return std::min(static_cast<std::int64_t>(std::floor(n)), recorded.load(std::memory_order_acquire));
    }
};
static_assert(std::atomic<std::int32_t>::is_always_lock_free);

}  // namespace shaker::mock
