#pragma once
// Consistency of the content of a recording: seals, consecutive numbers, a picture for each row.
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace shaker::test {

struct CameraContent {
    std::string camera;
    double rate_hz = 0;
    std::uint64_t frames = 0, pictures = 0;
    double last_frame_s = 0;    // master time of its last row
    double last_picture_s = 0;  // master time of the last complete picture, with or without a row
    std::uint64_t produced = 0, stored = 0, dropped = 0;  // counts in the recording
};

struct RecordedContent {
    double until_s = 0;         // master time at which the shortest series ends
    std::uint64_t missing = 0;  // blocks, samples and frames that are missing and not marked
    std::vector<CameraContent> cameras;
    std::vector<std::string> wrong;  // errors, one sentence each; empty: no error
};

/// Reads a finished recording with a DAC, an accelerometer and cameras, including every picture.
RecordedContent content_of(const std::filesystem::path& recording);

}  // namespace shaker::test
