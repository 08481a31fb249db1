#pragma once
// QueuedBlocks: states of the output at the starts of the blocks that the DAC may still hold. Real-time.
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "drivers/devices.hpp"
#include "drivers/synthesiser.hpp"
#include "drivers/trigger_train.hpp"

namespace shaker::acquisition {

/// Only blocks since the drive was last silent are kept: nothing before them needs to be taken back.
class QueuedBlocks {
public:
    /// Allocates memory for the blocks of a full queue; none if the DAC takes nothing back.
    QueuedBlocks(const DacInfo& dac, std::size_t block, const Synthesiser& synthesiser,
                 const TriggerTrain& triggers)
        : starts_(dac.takes_back() ? static_cast<std::size_t>(dac.queue_frames) / block + 2 : 0,
                  {synthesiser, triggers}) {}

    /// Call before each block is filled, after all commands for it.
    void add(const Synthesiser& synthesiser, const TriggerTrain& triggers) noexcept {
        if (starts_.empty()) return;
        if (synthesiser.silent()) clear();
        if (count_ == starts_.size()) {
            oldest_ = (oldest_ + 1) % starts_.size();
            --count_;
        }
        start(count_++) = {synthesiser, triggers};
    }
    void clear() noexcept { count_ = 0; }

    /// First sample to which the output can go back. At the first sample of the oldest block a stop would
    /// come before the commands for that block.
    [[nodiscard]] DacTick first(DacTick now) const noexcept {
        return count_ == 0 ? now : DacTick{starts_[oldest_].synthesiser.tick().n + 1};
    }
    /// Returns the output to sample `to`, which is at or after first(), and forgets all blocks. `volts` is
    /// overwritten; it has the length of a block.
    void go_back(DacTick to, Synthesiser& synthesiser, TriggerTrain& triggers,
                 std::span<double> volts) noexcept {
        std::size_t i = count_ - 1;
        while (start(i).synthesiser.tick() >= to) --i;
        const std::int64_t n = to.n - start(i).synthesiser.tick().n;
        synthesiser.go_back(start(i).synthesiser, volts.first(static_cast<std::size_t>(n)));
        triggers = start(i).triggers;
        triggers.skip(n);
        clear();
    }

private:
    struct Start {
        Synthesiser synthesiser;
        TriggerTrain triggers;
    };
    [[nodiscard]] Start& start(std::size_t i) noexcept { return starts_[(oldest_ + i) % starts_.size()]; }

    std::vector<Start> starts_;
    std::size_t oldest_ = 0, count_ = 0;
};

}  // namespace shaker::acquisition
