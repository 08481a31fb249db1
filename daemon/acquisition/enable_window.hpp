#pragma once
// EnableWindow: the blocks during which the enable output of the amplifier is on. Real-time.
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>

#include "drivers/synthesiser.hpp"

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

}  // namespace shaker::acquisition
