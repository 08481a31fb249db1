#pragma once
// Columns of the raw streams: each one's name, type, unit and meaning stand here, for writing, reading and
// FORMAT.md.
#include <array>
#include <cstddef>
#include <span>
#include <string>

#include "drivers/drive.hpp"

namespace shaker::recorded {

struct RawColumn {
    enum class Type { int32, int64, uint8, uint64, float64 };
    const char* group;  // under /entry; of a camera's column "raw"
    const char* name;
    Type type;
    const char* units;  // UDUNITS text
    const char* meaning;
    std::size_t values = 1;  // a row
};

/// Columns of a stream with one group.
inline std::string path_of(const RawColumn& column) { return std::string{column.group} + "/" + column.name; }
/// Columns of one camera.
inline std::string path_of(const RawColumn& column, const std::string& camera) {
    return std::string{column.group} + "/" + camera + "/" + column.name;
}

namespace raw {

using enum RawColumn::Type;
inline constexpr const char* drive = "raw/drive";
inline constexpr const char* changes = "raw/drive/changes";
inline constexpr const char* accelerometer = "raw/accelerometer";
inline constexpr const char* cameras = "raw";
inline constexpr std::size_t axes = 3;
inline constexpr std::size_t sighting_values = 3;  // of one target

inline constexpr RawColumn play_tick{drive, "play_tick", int64, "1", "DAC sample at which a block starts"},
    play_heard{drive, "play_heard", int64, "ns", "host time at which that sample left the converter"},
    play_lost{drive, "play_lost", int64, "1", "samples before it during which the DAC was empty"};
inline constexpr std::array plays{play_tick, play_heard, play_lost};

inline constexpr RawColumn first_tick{changes, "first_tick", int64, "1",
                                      "DAC sample at which the change starts"},
    ramp_samples{changes, "ramp_samples", int64, "1", "length of the ramp from the previous drive"},
    stop_samples{changes, "stop_samples", int64, "1", "length of a stop's ramp to zero; 0: not a stop"},
    taken_back{changes, "taken_back", int64, "1",
               "samples from first_tick on that a stop took back from the DAC: earlier rows that start at or "
               "after first_tick did not take effect"},
    ramp_periods{changes, "ramp_periods", int64, "1", "commanded length of the ramp in periods"},
    phase{changes, "phase", uint64, "1", "phase at first_tick in turns / 2^64"},
    phase_low{changes, "phase_low", uint64, "1", "next 64 bits of the phase"},
    step{changes, "step", uint64, "1", "phase step per sample in turns / 2^64"},
    step_low{changes, "step_low", uint64, "1", "next 64 bits of the step"},
    sequence{changes, "sequence", uint64, "1", "number of the command"},
    frequency{changes, "frequency", float64, "Hz", "commanded frequency"},
    harmonics_re{
        changes,      "harmonics_re", float64, "V", "drive = Im sum a_q exp(i q w t): real parts of a_q",
        max_harmonics},
    harmonics_im{changes, "harmonics_im", float64, "V", "imaginary parts of a_q", max_harmonics};
inline constexpr std::array drive_changes{first_tick, ramp_samples, stop_samples, taken_back, ramp_periods,
                                          phase,      phase_low,    step,         step_low,   sequence,
                                          frequency,  harmonics_re, harmonics_im};

inline constexpr RawColumn counts{
    accelerometer, "counts", int32, "count", "unchanged samples x, y, z, one row per sample", axes},
    block_first{accelerometer, "block_first", int64, "1", "number of a block's first sample"},
    block_arrived{accelerometer, "block_arrived", int64, "ns", "host time at which the block was read"},
    block_quality{accelerometer, "block_quality", uint8, "1",
                  "0: good; otherwise the sum of 1 after a gap, 2 clipped, 4 late"},
    block_size{accelerometer, "block_size", uint8, "1", "samples in the block"};
inline constexpr std::array blocks{counts, block_first, block_arrived, block_quality, block_size};

inline constexpr RawColumn tick{cameras, "tick", int64, "1",
                                "number of the exposure; missed exposures count"},
    arrived{cameras, "arrived", int64, "ns", "host time at which the frame was read"},
    stamp{cameras, "stamp", int64, "ns", "time of the camera's own clock; -2^63: no stamp"},
    mid_exposure{cameras, "mid_exposure", float64, "s",
                 "master time if the frame contains it, otherwise NaN"},
    quality{cameras, "quality", uint8, "1", "as block_quality"},
    picture{cameras, "picture", uint64, "1", "number in the pictures folder, from 1; 0: no picture"};
inline constexpr RawColumn sightings{cameras,
                                     "sightings",
                                     float64,
                                     "px",
                                     "x, y and standard error, for each target; NaN: not seen. Only of a "
                                     "camera that gives positions instead of "
                                     "pictures",
                                     sighting_values};
inline constexpr std::array frames{tick, arrived, stamp, mid_exposure, quality, picture, sightings};

struct Group {
    const char* path;
    const char* meaning;
    std::span<const RawColumn> columns;
};
/// All of them; the last one is there once a camera, below its path.
inline constexpr std::array groups{
    Group{drive, "times at which samples of the drive left the converter, one row per block", plays},
    Group{changes, "changes of the drive, sufficient to reproduce every sample to the bit", drive_changes},
    Group{accelerometer, "accelerometer", blocks}, Group{cameras, "frames of one camera", frames}};

}  // namespace raw

}  // namespace shaker::recorded
