#pragma once
// Limits: warning and abort levels of the motion, ramps of the stops, times of the watchdogs.
#include <array>
#include <bitset>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "daemon/safety/trip.hpp"
#include "drivers/settings_table.hpp"

namespace shaker::safety {

/// Above `warn` samples are counted, above `abort` the drive trips. Infinite: no such level.
struct Level {
    double warn = std::numeric_limits<double>::infinity();
    double abort = std::numeric_limits<double>::infinity();
    bool operator==(const Level&) const = default;
};

/// Causes that may trip. All are on. A test switches one off to show that no other cause replaces it. No
/// settings file contains this.
using Detectors = std::bitset<causes>;
inline constexpr Detectors all_detectors{(1ULL << causes) - 1};

struct Limits {
    Level acceleration{};         // peak, m/s^2
    Level acceleration_rms{};     // over two periods, m/s^2
    Level velocity{};             // peak, m/s
    Level displacement{};         // peak from the middle, m
    Level drive{};                // peak, V at the DAC
    Level transverse{0.25, 0.5};  // share of the peak along the axis
    Level coil_A{};               // A rms: heat of the coil as the steady current that gives the same heat
    double coil_A_per_V = 0;      // A in the coil per V at the DAC; 0: unknown, the heat is not checked
    double coil_time_s = 120;     // s, thermal time constant of the coil
    double force_n = std::numeric_limits<double>::infinity();  // N, peak; compared with predictions only
    /// In m/s^2; a sample at or beyond it is saturated.
    double sensor_range_mps2 = std::numeric_limits<double>::infinity();
    /// mm, least distance of the walker from the edge of the picture; negative: the walker may leave it.
    double edge_mm = 5;
    int tracking_lost_frames = 20;  // consecutive frames
    double soft_stop_s = 0.05;      // s, ramp to zero
    double hard_stop_s = 0.005;
    double missing_s = 0.02;  // s, longest time without accelerometer samples
    /// s, longest time without pictures of the walker from any camera; at least 10 frames.
    double camera_missing_s = 0.25;
    double watchdog_s = 0.5;  // s, longest time without progress of the control
    Detectors detectors{all_detectors};
    bool operator==(const Limits&) const = default;

    /// Length of the ramp to zero, s.
    [[nodiscard]] double stop_s(StopKind kind) const noexcept {
        return kind == StopKind::hard ? hard_stop_s : soft_stop_s;
    }
};

/// The names of a level: `velocity`, `mps` for the keys velocity_warn_mps and velocity_abort_mps of files and
/// velocity_abort_mps of the page's state; LIMit:VELocity:WARN and :ABORt in SCPI.
struct LevelRow {
    Level Limits::*level;
    const char* name;
    const char* unit;  // SI
    const char* scpi_name;
    const char* scpi_unit;  // SI
    const char* file_unit;
    double per_si;  // file units per SI unit
    /// `end`: &Level::warn or &Level::abort.
    [[nodiscard]] std::string file_key(double Level::*end) const { return key(end, file_unit); }
    [[nodiscard]] std::string key(double Level::*end) const { return key(end, unit); }

private:
    [[nodiscard]] std::string key(double Level::*end, const char* in) const;
};
/// Every level that a file may set and an order may lower.
inline constexpr std::array<LevelRow, 7> level_rows{
    {{&Limits::acceleration, "acceleration", "mps2", "ACCeleration", "M/S2", "mps2", 1},
     {&Limits::acceleration_rms, "acceleration_rms", "mps2", "ACCeleration:RMS", "M/S2", "mps2", 1},
     {&Limits::coil_A, "coil", "A", "COIL", "A", "A", 1},
     {&Limits::velocity, "velocity", "mps", "VELocity", "M/S", "mps", 1},
     {&Limits::displacement, "displacement", "m", "DISPlacement", "M", "mm", 1000},
     {&Limits::drive, "drive", "V", "DRIVe", "V", "V", 1},
     {&Limits::transverse, "transverse", "", "TRANsverse", "", "", 1}}};

/// Data sheets of shaker, sensor and DAC. Infinite: unknown, no limit.
struct DataSheet {
    double max_force_n = std::numeric_limits<double>::infinity();            // peak
    double moving_mass_kg = 0;                                               // armature
    double load_kg = 0;                                                      // base, fixture, walker
    double stroke_m = std::numeric_limits<double>::infinity();               // peak to peak, stop to stop
    double max_velocity_mps = std::numeric_limits<double>::infinity();       // peak
    double max_acceleration_mps2 = std::numeric_limits<double>::infinity();  // peak
    double sensor_range_mps2 = std::numeric_limits<double>::infinity();
    double sensor_block_s = 0;                                      // s, sampling time per delivered block
    double full_scale_V = std::numeric_limits<double>::infinity();  // of the DAC
    double max_coil_A = std::numeric_limits<double>::infinity();    // rms, continuous
    double coil_A_per_V = 0;                                        // A in the coil per V at the DAC
};

inline constexpr double standard_margin = 0.8;  // of the data sheet

/// Limits from the data sheets. Abort levels: `margin` (0..1) times the data sheet; warnings: 80 % of the
/// abort levels. Acceleration: the least of shaker, force / moved mass, and sensor; rms: of a
/// sine of that peak. Drive: the full scale
/// of the DAC. missing_s: 20 ms or 1.75 blocks of the accelerometer, whichever is longer.
Limits limits_of(const DataSheet& sheet, double margin = standard_margin);

/// Reads a table [limits]. Keys, all optional: margin (0.1..1, of the data sheet, for levels that are not
/// given), acceleration_warn_mps2, acceleration_abort_mps2, acceleration_rms_warn_mps2,
/// acceleration_rms_abort_mps2 (default: of a sine of the abort level), coil_warn_A, coil_abort_A,
/// coil_A_per_V, coil_time_s, velocity_warn_mps, velocity_abort_mps,
/// displacement_warn_mm, displacement_abort_mm (peak), drive_warn_V, drive_abort_V, transverse_warn,
/// transverse_abort (ratios), force_n, sensor_range_mps2, edge_mm, tracking_lost_frames, soft_stop_s
/// (0.02..0.2), hard_stop_s (0.001..0.02), missing_s, camera_missing_s, watchdog_s. Default of a warning
/// level: 80 % of its abort level. InputError for other keys and for a warning level above its abort
/// level.
Limits read_limits(SettingsTable table, const DataSheet& sheet);

/// A limit that an order may lower: one end of a level, or the walker's distance from the edge. All others
/// come from the settings files only.
struct LimitKey {
    Level Limits::*level = nullptr;  // null: edge_mm
    double Level::*end = &Level::abort;
};
/// Name of a limit in the settings files, and the units there per SI unit (of edge_mm: per mm).
std::pair<std::string, double> file_name(LimitKey key);
/// Lowers one limit (SI units), or raises edge_mm (mm), and keeps the others; a warning level stays at most
/// its abort level. InputError when the limit would be looser than it is.
void lower(Limits& limits, LimitKey key, double value);
/// `now` with the keys in which `is` differs from `was`: a level with both of its ends.
Limits with_changes(Limits now, const Limits& was, const Limits& is);

/// TOML from which read_limits() returns the same limits (except `detectors`).
std::string limits_text(const Limits& limits);

/// Share of the expected motion; a sensor that sees less is open.
inline constexpr double least_seen = 0.02;
/// Largest gain of a response over the data sheet's; the least is its inverse.
inline constexpr double most_sheet_gain = 4;

/// Half the levels of motion, drive, heat and force; shares and times stay.
Limits halved(Limits limits);

/// Largest relative error of gravity with which a bench may drive. `calibrated`: the sensor's gains come from
/// its calibration, which gravity has made.
constexpr double most_gravity_off(bool calibrated) noexcept { return calibrated ? 0.05 : 0.4; }

/// True when a sensor at rest that measures `seen` has not the gain of its rig file: not the gravity of the
/// place, m/s^2, to within `most`. A smaller mean is the offset of a sensor that does not measure gravity.
inline bool gravity_wrong(double seen, double gravity, double most) noexcept {
    constexpr double least_gravity = 0.5;  // m/s^2
    return seen >= least_gravity && std::abs(seen / gravity - 1) >= most;
}

}  // namespace shaker::safety
