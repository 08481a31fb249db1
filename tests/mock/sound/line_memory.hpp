#pragma once
// LineMemory: mapped file shared by a mock line input's owner and the PCM plug-in. Clock, faults and samples.
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace shaker::mock {

struct LineMemory {
    static constexpr std::uint64_t version = 0x73686b6d6f636b12;
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
    /// A card shows its samples some time after it has converted them, each at the same time: longer than the
    /// blocks in which they are recorded here.
    static constexpr std::int64_t shown_after_ns = 10'000'000;
    /// Samples that are shown at a time.
    [[nodiscard]] std::int64_t due(std::int64_t monotonic_ns) const noexcept {
        const double n =
            std::max(1e-9 * rate_hz * static_cast<double>(monotonic_ns - epoch_ns - shown_after_ns), 0.0);
        return std::min(static_cast<std::int64_t>(std::floor(n)), recorded.load(std::memory_order_acquire));
    }
};
static_assert(std::atomic<std::int32_t>::is_always_lock_free);

}  // namespace shaker::mock
