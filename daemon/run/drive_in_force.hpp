#pragma once
// Which drive command is in force, and since when.
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "drivers/synthesiser.hpp"
#include "drivers/time.hpp"

namespace shaker::run {

/// Numbers the drive commands and follows their start at the output. Times are master time, s.
class DriveInForce {
public:
    explicit DriveInForce(double dac_rate_hz) : dac_rate_hz_{dac_rate_hz} {}

    /// The number of the next command.
    std::uint64_t next() noexcept { return ++sequence_; }
    /// The newest command is a large change: no period counts as settled until the command is in force.
    void await() noexcept {
        awaited_ = sequence_;
        in_force_s_ = steady_from_s_ = INFINITY;
    }
    /// The newest command is the first one for the present target.
    void aim() noexcept {
        target_sequence_ = sequence_;
        target_from_s_ = INFINITY;
    }
    /// A change that the output has started. transient_s: settling time of the suspension, s.
    void add(const DriveChange& c, double transient_s) noexcept {
        // Number 0 is the stop of a trip, or the silence after lost time; the ramp up from it follows later.
        if (c.command.sequence < awaited_ || c.command.sequence == 0) return;
        in_force_s_ = counted_s(c.end(), dac_rate_hz_);
        if (c.command.sequence >= target_sequence_) target_from_s_ = std::min(target_from_s_, in_force_s_);
        if (!std::isfinite(steady_from_s_)) steady_from_s_ = in_force_s_ + transient_s;
    }

    [[nodiscard]] std::uint64_t newest() const noexcept { return sequence_; }
    /// Start of the awaited command; infinite while it is not in force.
    [[nodiscard]] double in_force_s() const noexcept { return in_force_s_; }
    /// Time at which the suspension has followed the newest large change; infinite while it has not started.
    [[nodiscard]] double steady_from_s() const noexcept { return steady_from_s_; }
    /// Start of the first command for the present target; infinite before it.
    [[nodiscard]] double target_from_s() const noexcept { return target_from_s_; }

private:
    double dac_rate_hz_;
    std::uint64_t sequence_ = 0, awaited_ = 0, target_sequence_ = 0;
    double in_force_s_ = 0, steady_from_s_ = 0, target_from_s_ = INFINITY;
};

}  // namespace shaker::run
