#pragma once
// Tables of the identified response of the base.
#include "daemon/control/identification.hpp"
#include "drivers/recorded/recording_file.hpp"

namespace shaker::recording {

/// Writes the group "identification": NXdata "response" against frequency at the highest level (magnitude,
/// phase, their errors, coherence, noise floor, changes since the lowest level), one NXdata per level
/// ("level_1", ...; the four highest levels), NXdata "transverse", and as single numbers polarity, gain and
/// turn relative to the data sheet, and the shaker's axis.
void write_identification(recorded::RecordingWriter& file, const control::IdentifiedResponse& response);
/// Places of this group.
std::vector<recorded::GroupLayout> identification_places();

}  // namespace shaker::recording
