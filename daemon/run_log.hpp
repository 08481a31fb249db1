#pragma once
// What happened in a run and when: in its recording, and in a journal that is on the disk at once.
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "drivers/replay/session_file.hpp"

namespace shaker {

struct LogEntry {
    double t_s = 0;     // master time
    std::string state;  // of the run: "identify"
    std::string text;   // one sentence; empty: the run came into this state
};

/// Whole periods of a measurement, s of master time.
struct MeasuredPart {
    double from_s = 0, to_s = 0;
};

/// The tables "events" and "measurements" of a recording.
std::vector<GroupLayout> run_log_places();
void write(SessionWriter& file, const LogEntry& entry);
void write(SessionWriter& file, const MeasuredPart& part);
/// The measurement that was begun last; none when there was none.
std::optional<MeasuredPart> read_measurement(const SessionReader& file);
std::vector<LogEntry> read_log(const SessionReader& file);

/// A file of lines that only grows: of each line its checksum, its length and the entry as JSON.
class Journal {
public:
    /// Begins a new one. DeviceError when that is not possible.
    explicit Journal(const std::filesystem::path& file);
    ~Journal();
    Journal(const Journal&) = delete;
    Journal& operator=(const Journal&) = delete;
    /// On the disk when this returns. DeviceError when it is not.
    void add(const LogEntry& entry);

private:
    std::filesystem::path file_;
    int descriptor_;
};

/// The entries up to the first line that is not whole; none when there is no such file.
std::vector<LogEntry> read_journal(const std::filesystem::path& file);

}  // namespace shaker
