#pragma once
// What every table of a camera says, whatever file it is in: geometry of the picture and what to follow.
#include <array>
#include <set>
#include <string>
#include <string_view>

#include "drivers/settings_table.hpp"
#include "drivers/view.hpp"

namespace shaker {

/// Reads name, frame_rate_hz, exposure_s, mm_per_px, distance_mm, along and the tables `target` (at least
/// one). Missing: frame_rate_hz and exposure_s are 0, along is the image's x. Names must not be in `taken`;
/// they are added. Other keys are left to the caller. InputError as SettingsTable gives it.
View read_view(SettingsTable& table, std::set<std::string>& taken);

/// The same keys and tables as TOML, for a table [[camera]].
std::string view_text(const View& view);

/// A unit vector in the axes of an accelerometer, of length 1 within 0.1 %, made exactly so.
std::array<double, 3> read_axis(SettingsTable& table, std::string_view key);

}  // namespace shaker
