#pragma once
// Tables of the tracked targets: tracks/<camera>/<target>.
#include "daemon/acquisition/streams.hpp"
#include "daemon/recording/tables/columns.hpp"
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

}  // namespace shaker::recording
