#pragma once
// The points of single recordings, for the fits to the law of friction.
#include <filesystem>
#include <vector>

#include "daemon/law/point.hpp"
#include "drivers/recorded/recording_file.hpp"

namespace shaker::campaign {

/// Gravity at the place, m/s^2: by the rig file, or the scene of a simulated bench.
double gravity_in(const recorded::RecordingReader& file);

/// Adds the measurements of a recording that have a finite v_D and base; others are left out. Returns
/// gravity. InputError that names the file for one that is damaged, is newer than this program, or has no
/// such measurement.
double add_recording(const std::filesystem::path& recording, std::vector<law::Point>& to);

}  // namespace shaker::campaign
