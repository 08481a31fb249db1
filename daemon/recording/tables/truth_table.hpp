#pragma once
// Tables of the true motion in a simulated rig: truth, truth/<camera>.
#include <vector>

#include "daemon/recording/tables/columns.hpp"
#include "drivers/simulated/world.hpp"

namespace shaker::recording {

/// Places for cameras with these names and frame rates.
std::vector<recorded::GroupLayout> truth_places(const std::vector<View>& views);
/// v_D: true mean velocity of the walker over the measured part, m/s.
void write_true_drift(recorded::RecordingWriter& file, double v_D);
/// True positions of base and walker in the middle of each exposure.
void write_truth(recorded::RecordingWriter& file, const std::string& camera,
                 const std::vector<simulated::PoseTruth>& poses);

}  // namespace shaker::recording
