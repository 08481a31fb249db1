#pragma once
// The single values of the group "process" that are known at the end of a recording.
#include <string>

#include "daemon/recording/tables/columns.hpp"
#include "daemon/recording/tables/run_tables.hpp"

namespace shaker::recording {

recorded::GroupLayout process_places();
/// There are no results, and why.
void write_not_reduced(recorded::RecordingWriter& file, const std::string& why);
/// Pieces of data that found no room.
void write_pieces_lost(recorded::RecordingWriter& file, std::uint64_t pieces);
/// Its writer ended without closing it.
void write_recovered(recorded::RecordingWriter& file, const std::string& how);
/// The part of master time that the results were made from; from_s is NaN where there are none.
void write_reduced_part(recorded::RecordingWriter& file, const MeasuredPart& part);
MeasuredPart read_reduced_part(const recorded::RecordingReader& file);
/// Why there are no results.
std::string read_not_reduced(const recorded::RecordingReader& file);

}  // namespace shaker::recording
