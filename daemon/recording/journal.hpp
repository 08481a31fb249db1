#pragma once
// The journal of a run: a file beside the recording. Each event is on the disk as soon as it is added.
#include <filesystem>
#include <vector>

#include "daemon/recording/tables/run_tables.hpp"
#include "drivers/descriptor.hpp"

namespace shaker::recording {

/// A file to which lines are appended. Each line has a checksum, its length and the entry as JSON.
class Journal {
public:
    /// Creates the file. DeviceError when that fails.
    explicit Journal(const std::filesystem::path& file);
    /// Returns when the entry is on the disk. DeviceError when it cannot be written.
    void add(const LogEntry& entry);

private:
    std::filesystem::path file_;
    Descriptor descriptor_;
};

/// The entries up to the first incomplete line; empty without such a file.
std::vector<LogEntry> read_journal(const std::filesystem::path& file);

}  // namespace shaker::recording
