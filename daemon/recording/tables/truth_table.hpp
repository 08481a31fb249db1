#pragma once
// Tables of a simulated rig's truth: truth/<camera>.
#include <vector>

#include "daemon/recording/tables/columns.hpp"
#include "drivers/simulated/truth.hpp"

namespace shaker::recording {

/// Of cameras with these names and frame rates.
std::vector<recorded::GroupLayout> truth_places(const std::vector<View>& views);
/// The walker's true mean velocity over the measured part, m/s.
void write_true_drift(recorded::RecordingWriter& file, double v_D);
/// Where base and walker really were in the middle of each exposure.
void write_truth(recorded::RecordingWriter& file, const std::string& camera,
                 const std::vector<simulated::PoseTruth>& poses);

}  // namespace shaker::recording
