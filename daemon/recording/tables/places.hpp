#pragma once
// All groups and columns of a recording except the raw streams.
#include <vector>

#include "drivers/recorded/recording_file.hpp"

namespace shaker::recording {

/// Version of the layout that this program writes; it reads all versions up to it (FORMAT.md lists them).
inline constexpr int schema_version = 11;
/// Since this version results are reduced as today: a replay computes them to the bit.
inline constexpr int results_since = 11;
/// Since this version v of a cycle is not smoothed across kinks.
inline constexpr int unsmoothed_since = 7;
/// Since this version targets are followed in pictures as today: a replay computes the tracks to the bit.
inline constexpr int tracks_since = 11;

/// Places for a header with known views. truth: with tables for the truth of a simulated rig.
std::vector<recorded::GroupLayout> recording_places(const recorded::RecordingHeader& header, bool truth);
/// Sets version and places in the header of a new recording.
void lay_out(recorded::RecordingHeader& header, bool truth);
/// InputError for a recording whose layout is newer than this program.
void require_known_schema(const recorded::RecordingReader& file);

}  // namespace shaker::recording
