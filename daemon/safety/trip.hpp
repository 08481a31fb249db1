#pragma once
// Trip: the reason for which the drive was stopped, and its text for the operator.
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace shaker::safety {

enum class Cause : std::uint8_t {
    acceleration,       // m/s^2, of one sample along the shaker's axis
    velocity,           // m/s, of one sample along the shaker's axis
    displacement,       // m from the mean position, of one sample along the shaker's axis
    transverse,         // peak across the axis / peak along the axis
    drive,              // V, peak requested of the DAC
    sensor_open,        // measured / predicted motion
    sensor_frozen,      // number of consecutive equal samples
    sensor_saturated,   // number of consecutive samples at the end of the range
    sensor_not_finite,  // a sample that is NaN or infinite
    sensor_missing,     // s, duration without samples
    residual,           // m/s^2, rms of measured minus predicted over a quarter of a period
    loop_divergence,    // residual of the loop / norm of the target
    harmonic_band,      // dB, amplitude of a harmonic against its target
    gain_limit,         // motion per volt / identified response, or drive / drive by the response
    polarity,           // measured / predicted motion, negative
    gravity,            // gravity in the reading / reference (earlier reading, or standard gravity)
    walker_edge,        // mm, distance of the walker from the edge of the picture
    tracking_lost,      // number of consecutive frames without the walker
    camera_missing,     // s, duration without pictures of the walker
    underrun,           // samples, duration of an underrun of the DAC
    watchdog,           // s, duration without progress of the control
    clock,              // ppm, change of rate between two clocks
    recorder,           // s, duration for which nothing could be recorded
    acceleration_rms,   // m/s^2, along the shaker's axis, over two periods
    coil_heat,          // A, rms current of the coil, over its thermal time constant
    operator_stop,      // requested by the operator
    abort_input,        // the contact of the abort input is not closed, or cannot be read
    base_motion,        // the base's motion by a camera / by the accelerometer
    mixer,              // number of changed controls of the sound cards
};
inline constexpr std::size_t causes = 29;

/// Soft: the measurement is no longer valid (ramp of Limits::soft_stop_s). Hard: the motion itself is
/// wrong (ramp of Limits::hard_stop_s).
enum class StopKind : std::uint8_t { soft, hard };

/// One exceeded limit, as first detected.
struct Trip {
    Cause cause{};
    StopKind stop = StopKind::soft;
    bool on_dac_clock = false;  // true: `tick` counts DAC samples; false: accelerometer samples
    int harmonic = 0;           // order of the harmonic if the cause concerns one; else 0
    double value = 0;           // in the unit of the cause
    double limit = 0;
    std::int64_t tick = 0;     // of the sample that exceeded the limit
    std::uint64_t number = 0;  // the output counts its trips from 1; 0: not answered by the output yet
};

/// True for a soft stop because the base did not move as predicted.
bool contradicts_prediction(const Trip& trip) noexcept;
/// True for a soft stop because the base did not follow its target.
bool misses_target(const Trip& trip) noexcept;

/// The word for a cause in settings and remote commands: "sensor_frozen".
const char* name(Cause cause) noexcept;
/// The cause whose name() is this word; empty for an unknown word.
std::optional<Cause> cause_named(std::string_view word) noexcept;
/// Unit of value and limit; empty for a ratio.
const char* unit_of(Cause cause) noexcept;
/// The event, with value, limit and unit: "the walker is 4.97 mm from the edge of the picture (at least
/// 5 mm)".
std::string finding(const Trip& trip);
/// What to do about it; empty for a stop by the operator.
const char* advice(Cause cause) noexcept;
/// One line for the operator: finding, advice, and the word of the cause with kind and sample of the stop.
std::string text(const Trip& trip);

/// Number of samples (or blocks) of each cause above its warning level, or above its trip level while no
/// limits are set. One thread counts, any thread reads.
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

/// One line for each cause that was counted: how often, and what to check.
std::vector<std::string> notes_on(const Warnings& warnings);

}  // namespace shaker::safety
