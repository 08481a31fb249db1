#pragma once
// Settings common to every table of a camera: geometry of the picture and targets.
#include <array>
#include <set>
#include <span>
#include <string>
#include <string_view>

#include "drivers/response/sensor_response.hpp"
#include "drivers/settings_table.hpp"
#include "drivers/view.hpp"

namespace shaker {

/// Reads name, frame_rate_hz, exposure_s, mm_per_px, distance_mm, along, scale_error, tilt_deg, the table
/// `lens` and the tables `target` (at least one). Defaults: 0, along the image's x, no lens. Names must not
/// be in `taken`; they are added to it. Other keys are left to the caller. InputError as from SettingsTable.
View read_view(SettingsTable& table, std::set<std::string>& taken);

/// A target's region from the four numbers of `roi_px`. InputError with the wrong number and what is allowed.
std::array<int, 4> roi_of(std::span<const double, 4> numbers);

/// The same keys and tables as TOML, for a table [[camera]].
std::string view_text(const View& view);

/// The shaker's direction in the axes of an accelerometer that measures the first `axes` of them: the key
/// `shaker_axis`, a unit vector whose length must be 1 within 0.1 % and is then normalised. Without the key,
/// or with "fit", it is all 0: derived from the motion; with one axis it is that axis.
std::array<double, 3> read_shaker_axis(SettingsTable& table, std::size_t axes);

/// The keys high_pass_hz and low_pass_hz of an accelerometer, each with _error_hz (default: a tenth of it),
/// _order and _damping, or low_pass_above_hz. Without the first the corner of one without gravity in its
/// reading is not known; one with gravity has none.
SensorResponse read_response(SettingsTable& table, bool gravity);

}  // namespace shaker
