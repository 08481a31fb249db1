#pragma once
// OutputGuard: the output thread checks its own volts and that the other threads are alive. Real-time.
// Time is counted in samples played, so a run in virtual time always trips at the same sample.
#include <algorithm>
#include <cstdint>
#include <optional>

#include "daemon/safety/delay_growth.hpp"
#include "daemon/safety/limits.hpp"
#include "daemon/safety/trip.hpp"
#include "drivers/data.hpp"

namespace shaker::safety {

/// State of the output before a block, and of the block before.
struct OutputSigns {
    std::int64_t tick = 0;         // next sample to be played
    bool silent = true;            // no drive
    double peak_V = 0;             // V, of the block
    double mean_square_V2 = 0;     // V^2, of the block
    std::uint64_t clamped = 0;     // samples cut at the limit since the start
    double largest_clamped_V = 0;  // V, largest requested |volts| of those
    std::uint64_t heard = 0;       // accelerometer samples whose level was checked
    std::uint64_t judged = 0;      // accelerometer blocks that were checked completely
    AccelTick checked_to{};        // accelerometer tick after the newest of their samples
    HostTime checked_arrived{};    // AccelBlock::arrived of the newest of these blocks
    PlayTime played{};             // of the block before
    std::int64_t gathered = 0;     // counter that the control increases while it runs
};

class OutputGuard {
public:
    /// accelerometer_rate_hz: nominal; 0: no accelerometer, its silence is not checked. Without
    /// limits all findings are counted as warnings and nothing trips.
    OutputGuard(double rate_hz, double accelerometer_rate_hz, std::optional<Limits> limits);

    /// Call before each block. A trip is reported once until rearm(). drive: a block above the abort level,
    /// or samples cut at it. sensor_missing: no accelerometer sample was checked for missing_s or 1.25
    /// blocks, whichever is longer, once the first has arrived or the drive is on; samples whose place in
    /// time is not known count for at most held_back_s; or, while the drive is on, the age of the newest
    /// checked sample has grown by more than both times together. coil_heat: with the current i =
    /// coil_A_per_V volts, the heat h follows coil_time_s dh/dt = i^2 - h from 0; its root exceeds the limit.
    /// watchdog: checked while the drive is on.
    std::optional<Trip> check(const OutputSigns& signs, Warnings& warnings) noexcept;
    void rearm() noexcept { reported_.reset(); }
    /// Replaces the limits from now on.
    void hold_to(const Limits& limits) noexcept;
    /// Longest time for which samples are checked for their level only, because their place in time is not
    /// known, s.
    static constexpr double held_back_s = 0.1;
    /// Time in which the rate of the accelerometer's clock is measured, s; its later drift, and the drift of
    /// stamps against the host's clock, that are not a growth of the samples' age, s/s.
    static constexpr double learn_rate_s = 8, most_rate_drift = 1e-3, most_stamp_drift = 1e-4;
    /// True if limits were given.
    [[nodiscard]] bool armed() const noexcept { return armed_; }
    /// Longest ramp to zero of a trip, s.
    [[nodiscard]] double longest_stop_s() const noexcept {
        return std::max(limits_.soft_stop_s, limits_.hard_stop_s);
    }
    /// Length of the ramp to zero, in samples.
    [[nodiscard]] std::int64_t stop_samples(StopKind kind) const noexcept;

private:
    std::optional<Trip> find(const OutputSigns& signs, Warnings& warnings) noexcept;
    std::optional<Trip> find_heat(const OutputSigns& signs, Warnings& warnings) noexcept;
    std::optional<Trip> find_silence(const OutputSigns& signs, Warnings& warnings) noexcept;
    [[nodiscard]] double growth_of_age(const OutputSigns& signs) noexcept;
    std::optional<Trip> trip(Cause cause, StopKind kind, double value, double limit, std::int64_t tick,
                             Warnings& warnings) noexcept;

    double rate_hz_, accelerometer_rate_hz_;
    Limits limits_;
    bool armed_;
    double least_patience_s_ = 0;  // 1.25 blocks of the accelerometer
    // Growth of the age by ticks, which also contains delays in the device, and by stamps, which needs no
    // rate.
    DelayGrowth by_ticks_{learn_rate_s, most_rate_drift}, by_stamps_{0, most_stamp_drift};
    Detectors reported_;          // causes reported since rearm()
    double heat_A2_ = 0;          // of the coil
    std::int64_t heated_to_ = 0;  // tick
    std::uint64_t clamped_ = 0, heard_ = 0, judged_ = 0;
    std::int64_t gathered_ = 0;
    std::int64_t heard_at_ = 0, judged_at_ = 0, gathered_at_ = 0;  // ticks of the last progress
};

}  // namespace shaker::safety
