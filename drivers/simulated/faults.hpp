#pragma once
// Faults of a simulated bench: tables [[fault]] of a scene.
#include <cstddef>
#include <initializer_list>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/settings_table.hpp"

namespace shaker::simulated {

/// In the order of their names in a scene.
enum class FaultKind {
    open,            // accelerometer: lead off; noise without signal or gravity
    frozen,          // accelerometer: the last sample is repeated
    saturated,       // accelerometer: at the ends of its range
    flipped,         // accelerometer: all signs inverted
    swapped,         // accelerometer: x, y, z delivered as y, z, x
    gain,            // accelerometer: signal multiplied by `value`
    drop,            // accelerometer: `value` samples are missing
    silent,          // accelerometer: nothing arrives; samples of that time are missing
    amplifier_gain,  // gain multiplied by `value`, from then on
    walker_off,      // walker taken off the table
    walker_on,       // walker put back
    underrun,  // underrun of the DAC: neither the block being written nor the `value` samples after it are
               // played
    camera_stall,   // camera: no frames; exposures of that time are missing
    camera_lose,    // camera: one frame is missing
    walker_hidden,  // camera: an object covers the walker
    held_back,      // accelerometer: samples arrive, but their place in time is known only at the end
    camera_gone,    // camera: its driver gives up
    late,           // accelerometer: samples arrive later and later, by `value` s each s; the delay stays
    contact_open,   // the contact of the abort input is open; a scene without this fault has no abort input
    amplifier_off,  // the amplifier passes nothing
    bad_sample,     // accelerometer: one sample reads `value` m/s^2 on x
    frozen_axis,    // accelerometer: x repeats its last value
};

struct SceneFault {
    FaultKind what{};
    double at_s = 0;                                         // master time of its first sample or exposure
    double for_s = std::numeric_limits<double>::infinity();  // duration; infinite: until the end
    double value = 0;
    std::string camera;  // name of the camera; empty: all cameras

    [[nodiscard]] bool lasts_at(double t) const noexcept { return t >= at_s && t < at_s + for_s; }
};

/// Throws InputError with file, line, key and value. `cameras`: names of the cameras.
std::vector<SceneFault> read_faults(std::vector<SettingsTable> tables,
                                    std::initializer_list<std::string_view> cameras);
/// The same as TOML.
std::string faults_text(const std::vector<SceneFault>& faults);

/// Returns faults of some kinds in order of time, each once.
class FaultQueue {
public:
    FaultQueue(const std::vector<SceneFault>& all, std::initializer_list<FaultKind> kinds,
               std::string_view camera = {});
    /// The next fault that has begun at master time t (s), or null.
    [[nodiscard]] const SceneFault* take(double t) noexcept;

private:
    std::vector<SceneFault> faults_;
    std::size_t next_ = 0;
};

/// Faults of some kinds that last for a time.
class LastingFaults {
public:
    LastingFaults(const std::vector<SceneFault>& all, std::initializer_list<FaultKind> kinds,
                  std::string_view camera = {});
    [[nodiscard]] bool at(FaultKind what, double t) const noexcept;
    /// Whether one is active at any time after `from`, until `to`.
    [[nodiscard]] bool between(FaultKind what, double from, double to) const noexcept;
    /// Sum of value times duration until t of the faults that have begun.
    [[nodiscard]] double growth_at(FaultKind what, double t) const noexcept;
    /// Product of the values of the faults that are active at t; 1 if there is none.
    [[nodiscard]] double product_at(FaultKind what, double t) const noexcept;

private:
    std::vector<SceneFault> faults_;
};

}  // namespace shaker::simulated
