#pragma once
// AccelBlocks: collects numbered samples in blocks for another thread. Real-time after construction.
#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <optional>

#include "drivers/data.hpp"
#include "drivers/devices.hpp"
#include "drivers/handover.hpp"

namespace shaker::iio {

/// Blocks are full, except before a gap, and are passed on through a ring. One thread adds, one other takes.
class AccelBlocks {
public:
    /// Counts of each axis at or beyond these limits are clipped.
    using Limits = std::array<std::array<std::int64_t, 2>, 3>;
    /// size: samples per full block, as many as the device delivers at a time, at most AccelBlock::capacity.
    AccelBlocks(const Limits& limits, int size)
        : limits_{limits},
          size_{std::clamp(size, 1, AccelBlock::capacity)},
          ring_{capacity / static_cast<std::size_t>(size_)} {}

    /// The next sample; `lost` samples are missing before it.
    void add(std::int64_t tick, std::int64_t lost, const std::array<std::int32_t, 3>& counts,
             HostTime arrived) noexcept;
    /// The next sample begins a block that is marked as coming after a gap, also when no loss is counted.
    void begin_after_gap() noexcept;
    [[nodiscard]] std::optional<AccelBlock> take() noexcept { return ring_.pop(); }

    /// Number of samples passed on, and lost (before arrival, or because the ring was full). Any thread.
    [[nodiscard]] std::uint64_t taken() const noexcept { return taken_; }
    [[nodiscard]] std::uint64_t lost() const noexcept { return lost_; }

private:
    static constexpr std::size_t capacity = 16384;  // samples: 4 s at 4 kHz

    void hand_over() noexcept;

    Limits limits_;
    int size_;
    Ring<AccelBlock> ring_;
    AccelBlock block_{.first = {}, .arrived = {}, .size = 0};
    std::atomic<std::uint64_t> taken_{0}, lost_{0};
};

}  // namespace shaker::iio
