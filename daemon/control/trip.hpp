#pragma once
// Why the drive was stopped: what crosses the threads, and the words for it.
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace shaker {

enum class Cause : std::uint8_t {
    acceleration,       // m/s^2, of one sample along the shaker's axis
    velocity,           // m/s, likewise
    displacement,       // m from the middle, likewise
    transverse,         // share of the motion along the axis
    drive,              // V asked of the DAC
    sensor_open,        // share of the predicted motion that is seen
    sensor_frozen,      // equal samples in a row
    sensor_saturated,   // samples in a row at the end of the range
    sensor_not_finite,  // no number
    sensor_missing,     // s without samples
    residual,           // m/s^2, measured minus predicted, rms of a quarter period
    loop_divergence,    // residual of the loop as a share of the target
    harmonic_band,      // dB of a harmonic against its target
    gain_limit,         // motion a drive against what is known of the shaker, or its inverse
    polarity,           // share of the predicted motion that is seen: below zero
    gravity,            // seen, as a share of what was seen before or of the earth's
    walker_edge,        // mm from the edge of the base
    tracking_lost,      // frames in a row
    camera_missing,     // s without pictures
    underrun,           // samples the DAC stood empty
    watchdog,           // s without a sign of life of the reduction
    clock,              // ppm between two clocks
    recorder,           // s for which nothing could be recorded
    operator_stop,      // asked for
};
inline constexpr std::size_t causes = 24;

/// Soft: the measurement is no longer valid. Hard: the motion itself is wrong.
enum class StopKind : std::uint8_t { soft, hard };

/// One violated limit, as it was seen first.
struct Trip {
    Cause cause{};
    StopKind stop = StopKind::soft;
    bool on_dac_clock = false;  // `tick` counts DAC samples; else accelerometer samples
    int harmonic = 0;           // which one, where the cause is of one
    double value = 0;           // in the unit of the cause
    double limit = 0;
    std::int64_t tick = 0;  // of the sample that violated
};

/// One word, as settings and remote commands have it: "sensor_frozen".
const char* name(Cause cause) noexcept;
/// The cause of such a word; none when there is no such cause.
std::optional<Cause> cause_named(std::string_view word) noexcept;
/// Of value and limit; empty for a share.
const char* unit_of(Cause cause) noexcept;
/// What happened with value, limit and unit, and what to look at: one line for the operator.
std::string text(const Trip& trip);

/// How often each cause was seen at its warning level, or tripped on nothing because no limits are set:
/// samples, or blocks where a cause is of a block. One thread counts, any reads.
class Warnings {
public:
    void count(Cause cause, std::uint64_t n = 1) noexcept {
        counts_[static_cast<std::size_t>(cause)].fetch_add(n, std::memory_order_relaxed);
    }
    [[nodiscard]] std::uint64_t operator[](Cause cause) const noexcept {
        return counts_[static_cast<std::size_t>(cause)].load(std::memory_order_relaxed);
    }

private:
    std::array<std::atomic<std::uint64_t>, causes> counts_{};
};

/// One line a cause that was counted: how often, and what to look at.
std::vector<std::string> notes_on(const Warnings& warnings);

}  // namespace shaker
