#pragma once
// Tables of the tracked targets: tracks/<camera>/<target>.
#include "daemon/acquisition/streams.hpp"
#include "daemon/recording/tables/columns.hpp"
#include "tracking/track.hpp"

namespace shaker::recording {

/// One row a frame. Times are written live as far as they are known and replaced when the recording is
/// completed.
extern const Table<tracking::Track> track_columns;

/// "tracks/top/walker".
std::string track_path(const std::string& camera, const Target& target);
/// Every target's track.
std::vector<RecordedTable> tables_of(const acquisition::Streams& streams);
/// The tracks' final times, in place of those that were written live.
void write_times(recorded::RecordingWriter& file, const acquisition::Streams& streams);
/// The tracks stored in a recording, in metres by the views of `header`: the recording's own, or with other
/// scales.
void read_tracks(const recorded::RecordingReader& file, const recorded::RecordingHeader& header,
                 acquisition::Streams& streams);

}  // namespace shaker::recording
