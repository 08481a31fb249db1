#pragma once
// The output loop: synthesiser, guard and latch of the drive. A trip latches the output; only an operator's
// clear that was given after the newest trip and the newest abort unlatches it.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "daemon/acquisition/channels.hpp"
#include "daemon/safety/output_guard.hpp"
#include "drivers/devices.hpp"
#include "drivers/synthesiser.hpp"
#include "drivers/trigger_train.hpp"

namespace shaker::acquisition {

/// The enable output is on from `before_s` before the first sample of a drive until after_s behind its last
/// one. A command at rest is kept back until the amplifier has had `before_s` to switch on. Without an enable
/// output (before_s = 0) nothing is kept back. Thread safety: the output thread.
class EnableWindow {
public:
    /// Time for which the tone goes on behind the last sample of the drive, s; then at most one block more.
    static constexpr double after_s = 0.02;

    EnableWindow(double rate_hz, double before_s) noexcept
        : before_{std::llround(before_s * rate_hz)}, after_{std::llround(after_s * rate_hz)} {}

    /// The command that takes effect with the next block: the newest one, when it may. A command for a
    /// stopped or sounding output, and a soft stop, is never kept back.
    [[nodiscard]] std::optional<DriveCommand> admit(std::optional<DriveCommand> newest,
                                                    const Synthesiser& synthesiser) noexcept {
        if (newest) kept_ = newest;
        if (!kept_) return std::nullopt;
        const std::int64_t now = synthesiser.tick().n;
        const bool starts =
            kept_->stop_s <= 0 && kept_->volts.order() > 0 && synthesiser.silent() && !synthesiser.stopped();
        if (starts && before_ > 0) {
            if (!on_) since_ = now;
            on_ = true;
            if (now < since_ + before_) return std::nullopt;
        }
        return std::exchange(kept_, std::nullopt);
    }
    /// Call for each filled block. first: its first sample; drives_until: sample after the last one of the
    /// drive that was not zero.
    void note(std::int64_t first, const Synthesiser& synthesiser, std::int64_t drives_until) noexcept {
        const bool drives = before_ > 0 && (kept_ || !synthesiser.silent() || synthesiser.waits());
        on_ = drives || (on_ && first < drives_until + after_);
    }
    /// The DAC ran empty: the amplifier may have switched off. A command that was kept back is dropped.
    void restart() noexcept {
        on_ = false;
        kept_.reset();
    }

    /// For the samples of the last block.
    [[nodiscard]] bool on() const noexcept { return on_; }

private:
    std::int64_t before_, after_;  // samples
    std::int64_t since_ = 0;       // sample with which the output went on
    bool on_ = false;
    std::optional<DriveCommand> kept_;
};

/// States of the output at the starts of the blocks that the DAC may still hold.
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

struct DriveOutput {
    /// block: samples per write. limits: enforced by the guard; every sample stays below the drive's abort
    /// level; empty: no guard. accelerometer_rate_hz: of the accelerometer whose silence stops the drive;
    /// 0: no accelerometer.
    DriveOutput(const DacInfo& dac, double frequency, double frames_per_second, std::size_t block,
                const std::optional<safety::Limits>& limits = {}, double accelerometer_rate_hz = 0);
    double full_scale_V;
    double rate_hz;
    Synthesiser synthesiser;
    safety::OutputGuard guard;
    TriggerTrain triggers;
    std::vector<double> volts, pulses;
    QueuedBlocks queued;
    EnableWindow enable;
    bool has_contact = false;                       // there is an abort input
    std::uint64_t openings = 0, contact_reads = 0;  // values of the Channels that were answered
    std::int64_t contact_read_at = 0;               // DAC sample of the last reading
    std::int64_t drives_until = 0;                  // DAC sample after the last one that was not zero
    PlayTime played;                                // of the last block
    std::uint64_t underruns = 0;                    // of the DAC since the start
    std::int64_t empty_from = 0, empty_to = 0;      // DAC samples: the last time the DAC was empty
    std::uint64_t aborted = 0;                      // value of Channels::aborts that was answered
    bool failed = false;                            // a loop has failed and its stop was ordered
    safety::Trip newest{};                          // number 0: no trip yet
    std::optional<safety::Trip> unreported;         // newest trip that found a full ring
    std::optional<Clearance> clearance;             // waits for silence
};

/// Answers trips (also its own), aborts and clears, takes the newest drive, fills one block and plays it. A
/// stop starts with the first sample of that block. Before a hard stop, queued samples are taken back from
/// the DAC if the drive ends earlier by it: the block then starts behind the last sample that stays, and the
/// change that reports the stop has their number. The enable output of the amplifier follows the drive
/// (EnableWindow). Real-time except for Dac::write.
void output_step(DriveOutput& output, Dac& dac, Channels& channels);

}  // namespace shaker::acquisition
