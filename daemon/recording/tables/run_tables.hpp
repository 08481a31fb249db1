#pragma once
// Tables of the course of a run: events and started measurements; and the single values of the group
// "process" that are known at its end.
#include <optional>
#include <string>
#include <vector>

#include "daemon/recording/tables/columns.hpp"
#include "drivers/recorded/recording_file.hpp"

namespace shaker::recording {

struct LogEntry {
    double t_s = 0;     // master time
    std::string state;  // of the run: "identify"
    std::string text;   // one sentence; empty: the run entered this state
};

/// Whole periods of a measurement, s of master time.
struct MeasuredPart {
    double from_s = 0, to_s = 0;
    bool operator==(const MeasuredPart&) const = default;
};

/// The tables "events" and "measurements" of a recording.
std::vector<recorded::GroupLayout> run_places();
void write(recorded::RecordingWriter& file, const LogEntry& entry);
void write(recorded::RecordingWriter& file, const MeasuredPart& part);
/// The measurement that was started last; empty without one.
std::optional<MeasuredPart> read_measurement(const recorded::RecordingReader& file);
std::vector<LogEntry> read_log(const recorded::RecordingReader& file);

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
