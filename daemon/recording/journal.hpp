#pragma once
// The journal of a run: its events in a file that is on the disk at once, beside the recording.
#include <filesystem>
#include <vector>

#include "daemon/recording/tables/run_tables.hpp"

namespace shaker::recording {

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

}  // namespace shaker::recording
