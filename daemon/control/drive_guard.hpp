#pragma once
// What the output thread watches itself: its own volts and the signs of life of the threads beside it.
// Real-time. Time is counted in samples played, so that a run in virtual time always trips at the same one.
#include <cstdint>
#include <optional>

#include "daemon/control/limits.hpp"
#include "daemon/control/trip.hpp"

namespace shaker {

/// The output before a block: what became of the one before.
struct OutputSigns {
    std::int64_t tick = 0;            // next sample to be played
    bool silent = true;               // nothing is driven
    double peak_V = 0;                // of the block
    std::uint64_t clamped = 0;        // samples cut at the limit since the start
    double largest_clamped_V = 0;     // asked for, among those
    std::int64_t lost = 0;            // samples the DAC stood empty
    std::uint64_t signs_of_life = 0;  // of the accelerometer, since the start
    std::int64_t gathered = 0;        // mark that the reduction moves on while it lives
};

class DriveGuard {
public:
    /// accelerometer_rate_hz: nominal; 0: there is none, its silence is not watched. Without limits
    /// everything is counted as a warning and nothing trips.
    DriveGuard(double rate_hz, double accelerometer_rate_hz, std::optional<Limits> limits);

    /// Before each block. What trips is told once until rearm(). The accelerometer is silent when no block
    /// has come for missing_s or one and a quarter of a block's own length, whichever is longer, and the
    /// first has come or the drive is on. The reduction's life counts while the drive is on.
    std::optional<Trip> check(const OutputSigns& signs, Warnings& warnings) noexcept;
    void rearm() noexcept { told_.reset(); }
    /// Other levels from now on.
    void hold_to(const Limits& limits) noexcept { limits_ = limits; }
    /// Limits were given.
    [[nodiscard]] bool armed() const noexcept { return armed_; }
    /// Samples of the ramp to zero.
    [[nodiscard]] std::int64_t stop_samples(StopKind kind) const noexcept;

private:
    std::optional<Trip> find(const OutputSigns& signs, Warnings& warnings) noexcept;
    std::optional<Trip> trip(Cause cause, StopKind kind, double value, double limit, std::int64_t tick,
                             Warnings& warnings) noexcept;

    double rate_hz_;
    Limits limits_;
    bool armed_;
    bool has_accelerometer_;
    double patience_s_;  // with the accelerometer
    Detectors told_;     // since rearm()
    std::uint64_t clamped_ = 0, signs_of_life_ = 0;
    std::int64_t gathered_ = 0;
    std::int64_t block_at_ = 0, gathered_at_ = 0;  // ticks of the last signs of life
};

}  // namespace shaker
