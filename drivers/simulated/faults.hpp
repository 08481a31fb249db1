#pragma once
// What goes wrong on a simulated bench, and when: tables [[fault]] of a scene.
#include <cstddef>
#include <initializer_list>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/settings_table.hpp"

namespace shaker {

/// In the order of their names in a scene.
enum class FaultKind {
    open,            // accelerometer: its lead is off; noise without signal or gravity
    frozen,          // it repeats its last sample
    saturated,       // it sits on its rails
    flipped,         // all signs are wrong
    swapped,         // x, y, z arrive as y, z, x
    gain,            // its signal is `value` times what it should be
    drop,            // `value` samples are missing
    silent,          // nothing comes, and what was sampled meanwhile is missing
    amplifier_gain,  // `value` times the scene's, from then on
    walker_off,      // taken off the table
    walker_on,       // put back
    underrun,       // the DAC runs empty: the block being written is not played, nor `value` samples after it
    camera_stall,   // no frames; what was exposed meanwhile is missing
    camera_lose,    // one frame is missing
    walker_hidden,  // something else covers the walker: pictures show none
};

struct SceneFault {
    FaultKind what{};
    double at_s = 0;                                         // master time of its first sample or exposure
    double for_s = std::numeric_limits<double>::infinity();  // how long it lasts; without end
    double value = 0;
    std::string camera;  // of a camera's fault: its name; empty: all

    [[nodiscard]] bool lasts_at(double t) const noexcept { return t >= at_s && t < at_s + for_s; }
};

/// Throws InputError with file, line, key and value; `cameras` are the names there are.
std::vector<SceneFault> read_faults(std::vector<SettingsTable> tables,
                                    std::initializer_list<std::string_view> cameras);
/// The same as TOML.
std::string faults_text(const std::vector<SceneFault>& faults);

/// Hands out faults of some kinds in order of time, each once.
class FaultQueue {
public:
    FaultQueue(const std::vector<SceneFault>& all, std::initializer_list<FaultKind> kinds,
               std::string_view camera = {});
    /// The next that has begun at master time t (s), or null.
    [[nodiscard]] const SceneFault* take(double t) noexcept;

private:
    std::vector<SceneFault> faults_;
    std::size_t next_ = 0;
};

/// Faults of some kinds that last.
class LastingFaults {
public:
    LastingFaults(const std::vector<SceneFault>& all, std::initializer_list<FaultKind> kinds,
                  std::string_view camera = {});
    [[nodiscard]] bool at(FaultKind what, double t) const noexcept;
    /// Product of the values of those that last at t; 1 without.
    [[nodiscard]] double product_at(FaultKind what, double t) const noexcept;

private:
    std::vector<SceneFault> faults_;
};

}  // namespace shaker
