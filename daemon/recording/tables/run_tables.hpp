#pragma once
// Tables of the course of a run: events and started measurements.
#include <optional>
#include <string>
#include <vector>

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

}  // namespace shaker::recording
