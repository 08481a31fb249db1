#include "drivers/hardware/iio/accel_blocks.hpp"

namespace shaker::iio {

void AccelBlocks::add(std::int64_t tick, std::int64_t lost, const std::array<std::int32_t, 3>& counts,
                      HostTime arrived) noexcept {
    if (lost > 0) {
        begin_after_gap();
        lost_ += static_cast<std::uint64_t>(lost);
    }
    if (block_.size == 0) block_.first.n = tick;
    block_.counts[static_cast<std::size_t>(block_.size++)] = counts;
    block_.arrived = arrived;
    for (std::size_t k = 0; k < 3; ++k)
        if (counts[k] <= limits_[k][0] || counts[k] >= limits_[k][1])
            block_.quality = block_.quality | Quality::clipped;
    if (block_.size == size_) hand_over();
}

void AccelBlocks::begin_after_gap() noexcept {
    if (block_.size > 0) hand_over();
    block_.quality = block_.quality | Quality::gap;
}

void AccelBlocks::hand_over() noexcept {
    const auto size = static_cast<std::uint64_t>(block_.size);
    const bool pushed = ring_.push(block_);
    (pushed ? taken_ : lost_) += size;
    block_.size = 0;
    block_.quality = pushed ? Quality::good : Quality::gap;
}

}  // namespace shaker::iio
