#pragma once
// Tables of the tracked targets, tracks/<camera>/<target>, and of the true motion in a simulated rig, truth
// and truth/<camera>.
#include <vector>

#include "daemon/acquisition/streams.hpp"
#include "daemon/recording/tables/columns.hpp"
#include "drivers/simulated/world.hpp"
#include "tracking/tracker.hpp"

namespace shaker::recording {

/// One row per frame. Times are provisional and are replaced when the recording is completed.
extern const Table<tracking::Track> track_columns;

/// "tracks/top/walker".
std::string track_path(const std::string& camera, const Target& target);
/// The tracks of all targets.
std::vector<RecordedTable> tables_of(const acquisition::Streams& streams);
/// Replaces the provisional times of the tracks by the final ones.
void write_times(recorded::RecordingWriter& file, const acquisition::Streams& streams);
/// Reads the tracks of a recording and scales them to metres by the views of `header`, which may differ from
/// the recording's own header.
void read_tracks(const recorded::RecordingReader& file, const recorded::RecordingHeader& header,
                 acquisition::Streams& streams);

/// Places for cameras with these names and frame rates.
std::vector<recorded::GroupLayout> truth_places(const std::vector<View>& views);
/// v_D: true mean velocity of the walker over the measured part, m/s.
void write_true_drift(recorded::RecordingWriter& file, double v_D);
/// True positions of base and walker in the middle of each exposure.
void write_truth(recorded::RecordingWriter& file, const std::string& camera,
                 const std::vector<simulated::PoseTruth>& poses);

}  // namespace shaker::recording
