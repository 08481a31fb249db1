#pragma once
// How far the base may go: warning and abort levels, times of the stops and of the watchdogs.
#include <bitset>
#include <limits>
#include <string>

#include "daemon/control/trip.hpp"
#include "drivers/settings_table.hpp"

namespace shaker {

/// `warn` is counted, `abort` trips. Infinite: no such level.
struct Level {
    double warn = std::numeric_limits<double>::infinity();
    double abort = std::numeric_limits<double>::infinity();
    bool operator==(const Level&) const = default;
};

/// What may trip, by cause. All on; a test switches one off to show that nothing else stands in for it. Not
/// in any file.
using Detectors = std::bitset<causes>;
inline constexpr Detectors all_detectors{(1ULL << causes) - 1};

struct Limits {
    Level acceleration{};                                      // peak, m/s^2
    Level velocity{};                                          // peak, m/s
    Level displacement{};                                      // peak from the middle, m
    Level drive{};                                             // peak, V at the DAC
    Level transverse{0.25, 0.5};                               // share of the peak along the axis
    double force_n = std::numeric_limits<double>::infinity();  // peak; held against predictions only
    double sensor_range_mps2 = std::numeric_limits<double>::infinity();  // a sample there is saturated
    double edge_mm = 5;  // least distance of the walker from the edge of the base; below 0: it may leave
    int tracking_lost_frames = 20;  // in a row
    double soft_stop_s = 0.05;      // ramps to zero
    double hard_stop_s = 0.005;
    double missing_s = 0.02;                                            // without accelerometer samples
    double camera_missing_s = std::numeric_limits<double>::infinity();  // without pictures of any one camera
    double watchdog_s = 0.5;  // without a sign of life of the reduction
    Detectors detectors{all_detectors};
    bool operator==(const Limits&) const = default;

    /// Length of the ramp to zero, s.
    [[nodiscard]] double stop_s(StopKind kind) const noexcept {
        return kind == StopKind::hard ? hard_stop_s : soft_stop_s;
    }
};

/// What shaker, sensor and DAC can do. Infinite: not known, no limit.
struct DataSheet {
    double max_force_n = std::numeric_limits<double>::infinity();            // peak
    double moving_mass_kg = 0;                                               // armature
    double load_kg = 0;                                                      // base, fixture, walker
    double stroke_m = std::numeric_limits<double>::infinity();               // peak to peak, stop to stop
    double max_velocity_mps = std::numeric_limits<double>::infinity();       // peak
    double max_acceleration_mps2 = std::numeric_limits<double>::infinity();  // peak
    double sensor_range_mps2 = std::numeric_limits<double>::infinity();
    double sensor_block_s = 0;                                      // sampling that comes at a time
    double full_scale_V = std::numeric_limits<double>::infinity();  // of the DAC
};

/// Abort levels at `margin` (0..1) of the data sheet, warnings at 80 % of those; acceleration at the least of
/// what shaker, force over moved mass and sensor allow. The drive may use all of the DAC. The accelerometer
/// may be silent for 20 ms, or 1.75 of its blocks where those are longer.
Limits limits_of(const DataSheet& sheet, double margin = 0.8);

/// Reads a table [limits]: margin (0.1..1, of the data sheet, for what the table does not say),
/// acceleration_warn_mps2, acceleration_abort_mps2, velocity_warn_mps, velocity_abort_mps,
/// displacement_warn_mm, displacement_abort_mm (peak), drive_warn_V, drive_abort_V, transverse_warn,
/// transverse_abort (shares), force_n, sensor_range_mps2, edge_mm, tracking_lost_frames, soft_stop_s
/// (0.02..0.2), hard_stop_s (0.001..0.02), missing_s, camera_missing_s, watchdog_s. All may be missing; a
/// warning level that is missing is 80 % of the abort level. InputError for anything else, and for a warning
/// beyond its abort.
Limits read_limits(SettingsTable table, const DataSheet& sheet);

/// As a table that read_limits() turns into the same limits (but for `detectors`).
std::string limits_text(const Limits& limits);

}  // namespace shaker
