#pragma once
// Which of the commands that were sent to the output is in force, and since when.
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "drivers/synthesiser.hpp"
#include "drivers/ticks.hpp"

namespace shaker::run {

/// Times are master time, s.
class DriveInForce {
public:
    explicit DriveInForce(double dac_rate_hz) : dac_rate_hz_{dac_rate_hz} {}

    /// The number of the next command.
    std::uint64_t next() noexcept { return ++sequence_; }
    /// The newest command changes the drive much: until it is known to be in force, no period counts as
    /// settled.
    void await() noexcept {
        awaited_ = sequence_;
        in_force_s_ = steady_from_s_ = INFINITY;
    }
    /// The newest command is the first that goes for the present target.
    void aim() noexcept {
        target_sequence_ = sequence_;
        target_from_s_ = INFINITY;
    }
    /// A change that the output has begun; transient_s: until the suspension has followed it.
    void add(const DriveChange& c, double transient_s) noexcept {
        // The silence after lost time has no number: the ramp up from it is still to come.
        if (c.stop > 0 || c.command.sequence < awaited_ || c.command.sequence == 0) return;
        in_force_s_ = counted_s(DacTick{c.first.n + c.ramp}, dac_rate_hz_);
        if (c.command.sequence >= target_sequence_) target_from_s_ = std::min(target_from_s_, in_force_s_);
        if (!std::isfinite(steady_from_s_)) steady_from_s_ = in_force_s_ + transient_s;
    }

    [[nodiscard]] std::uint64_t newest() const noexcept { return sequence_; }
    /// The awaited command is in force from here on; infinite while that is not known.
    [[nodiscard]] double in_force_s() const noexcept { return in_force_s_; }
    /// The newest large change has been in effect since.
    [[nodiscard]] double steady_from_s() const noexcept { return steady_from_s_; }
    /// A command for the present target has been in force since.
    [[nodiscard]] double target_from_s() const noexcept { return target_from_s_; }

private:
    double dac_rate_hz_;
    std::uint64_t sequence_ = 0, awaited_ = 0, target_sequence_ = 0;
    double in_force_s_ = 0, steady_from_s_ = 0, target_from_s_ = INFINITY;
};

}  // namespace shaker::run
