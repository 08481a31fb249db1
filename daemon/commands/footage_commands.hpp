#pragma once
// shakerd reduce and shakerd track: sessions of footage that shakerd did not record.
#include <filesystem>

#include "drivers/recorded/recording_file.hpp"

namespace shaker::commands {

/// Files that a session.toml names, as text for session_files().
std::string read_session_names(const std::filesystem::path& session);

/// Files that the commands below open to read a session.
struct SessionFiles {
    std::vector<std::filesystem::path> folders;  // whose names are read
    std::vector<std::filesystem::path> files;
    std::uint64_t bytes = 0;  // size of all
};
/// Those of `names`, a text of read_session_names(). Only names and sizes are read.
SessionFiles session_files(const std::filesystem::path& session, std::string_view names);

/// Loads what decodes movies and images.
void load_decoders() noexcept;

struct ReduceOptions {
    std::filesystem::path session;
    std::filesystem::path out;  // empty: no recording
    recorded::KeptPictures pictures = recorded::KeptPictures::region;
    bool json = false;
};
/// Throws InputError when the recording exists already, finished or not.
void require_new_recording(const ReduceOptions& options);
/// Reduces a session and prints the result.
void reduce_session(const ReduceOptions& options);

struct TrackOptions {
    std::filesystem::path session;
    std::filesystem::path out;  // CSV file; empty: only a summary is printed
    int csv = -1;               // its descriptor
    bool json = false;
};
/// Tracks the targets of a session.
void track_session(const TrackOptions& options);

}  // namespace shaker::commands
