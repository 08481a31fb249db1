#pragma once
// How the base answered to the drive, as a recording keeps it.
#include "daemon/control/identification.hpp"
#include "drivers/recorded/recording_file.hpp"

namespace shaker::recording {

/// The group "identification": NXdata "response" (against frequency, highest level: magnitude, phase, their
/// errors, coherence, noise floor, and what changed since the lowest level), one NXdata a level ("level_1",
/// ...), NXdata "transverse", and polarity, gain and turn against the data sheet, and the shaker's axis.
/// Of the levels the four highest are kept.
void write_identification(recorded::RecordingWriter& file, const control::IdentifiedResponse& response);
/// What that needs places for.
std::vector<recorded::GroupLayout> identification_places();

}  // namespace shaker::recording
