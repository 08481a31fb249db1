#pragma once
// shakerd reduce and shakerd track: sessions of footage that shakerd did not record.
#include <filesystem>

#include "drivers/recorded/recording_file.hpp"

namespace shaker::commands {

struct ReduceOptions {
    std::filesystem::path session;
    std::filesystem::path out;  // empty: no recording
    recorded::KeptPictures pictures = recorded::KeptPictures::region;
    bool json = false;
};
/// Reduces a session and prints the result.
void reduce_session(const ReduceOptions& options);

struct TrackOptions {
    std::filesystem::path session;
    std::filesystem::path out;  // CSV file; empty: only a summary is printed
    bool json = false;
};
/// Tracks the targets of a session.
void track_session(const TrackOptions& options);

}  // namespace shaker::commands
