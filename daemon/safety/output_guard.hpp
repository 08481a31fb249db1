#pragma once
// OutputGuard: the output thread checks its own volts and that the other threads are alive. Real-time.
// Time is counted in samples played, so a run in virtual time always trips at the same sample.
#include <algorithm>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>

#include "daemon/safety/limits.hpp"
#include "daemon/safety/trip.hpp"
#include "drivers/data.hpp"

namespace shaker::safety {

/// By how much a delay exceeds its least value, also when it is measured between two clocks of different
/// rates. The least delay is a line m(t) = m0 + r t. It is set from the delays after the first second, in
/// which buffers fill and empty. The rate r is measured between the first and the last quarter of `learn_s`.
/// Later the line follows the delay, up by at most `most_drift` s/s and down by at most 0.1 s/s: a delay that
/// falls for a moment is not a new least value, and a drift of the clocks is not a growth.
class DelayGrowth {
public:
    /// learn_s: s, time in which r is measured; 0: one clock measures both ends, r = 0. most_drift: largest
    /// change of r that is not a growth, s/s.
    constexpr DelayGrowth(double learn_s, double most_drift) noexcept
        : learn_s_{learn_s}, most_drift_{most_drift} {}

    /// Delay at a time above the least delay, s; 0 while that is not known. Any constant may be added to the
    /// delays. Call it at least a few times a second.
    double add(double now_s, double delay_s) noexcept {
        if (!begun_) known_from_s_ = now_s + settle_s;
        const double step_s = std::exchange(begun_, true) ? std::max(0.0, now_s - last_s_) : 0;
        last_s_ = now_s;
        const double since_s = now_s - known_from_s_;
        if (since_s < 0) return 0;
        if (!known_) {
            if (since_s <= 0.25 * learn_s_) first_s_ = std::min(first_s_, delay_s);
            if (since_s >= 0.75 * learn_s_) least_s_ = std::min(least_s_, delay_s);
            if (since_s < learn_s_) return 0;
            known_ = true;
            if (learn_s_ > 0) rate_ = (least_s_ - first_s_) / (0.75 * learn_s_);
        }
        least_s_ += rate_ * step_s;
        least_s_ += std::clamp(delay_s - least_s_, -fall * step_s, most_drift_ * step_s);
        return delay_s - least_s_;
    }

private:
    static constexpr double settle_s = 1, fall = 0.1;

    double learn_s_, most_drift_;
    bool begun_ = false, known_ = false;
    double last_s_ = 0, known_from_s_ = 0;
    double first_s_ = std::numeric_limits<double>::infinity(), least_s_ = first_s_;
    double rate_ = 0;  // s/s
};

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
    /// time is not known count for at most held_back_s; or the age of the newest checked sample has grown by
    /// more than both times together, also at rest, so that no drive starts on old samples. coil_heat: with
    /// the current i = coil_A_per_V volts, the heat h follows coil_time_s dh/dt = i^2 - h from 0; its root
    /// exceeds the limit. watchdog: checked while the drive is on.
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
