#pragma once
// The single values of the group "process" that are known at the end of a recording.
#include <string>

#include "daemon/recording/tables/columns.hpp"
#include "daemon/recording/tables/run_tables.hpp"

namespace shaker::recording {

recorded::GroupLayout process_places();
/// Writes the reason why there are no results.
void write_not_reduced(recorded::RecordingWriter& file, const std::string& why);
/// Pieces of data lost because the disk was too slow.
void write_pieces_lost(recorded::RecordingWriter& file, std::uint64_t pieces);
/// Writes how the writer of a recovered file ended.
void write_recovered(recorded::RecordingWriter& file, const std::string& how);
/// The part of master time from which the results were made; from_s is NaN without results.
void write_reduced_part(recorded::RecordingWriter& file, const MeasuredPart& part);
MeasuredPart read_reduced_part(const recorded::RecordingReader& file);
/// Reason why there are no results.
std::string read_not_reduced(const recorded::RecordingReader& file);

}  // namespace shaker::recording
