#pragma once
// The data that a whole bench sends to its recording, in real time and without devices, and the cost of
// recording.
#include <filesystem>

#include "daemon/recording/recorder.hpp"

namespace shaker::test {

struct LiveStreams {
    double seconds = 20;
    double dac_rate_hz = 192000;
    std::size_t dac_block = 960;  // 5 ms
    double accelerometer_rate_hz = 50000;
    double frame_rate_hz = 1000;  // each of two cameras, with two targets; no pictures
};

struct LiveCost {
    double wall_s = 0;
    double recorder_s = 0;      // processor time of the recorder's thread
    double feeder_s = 0;        // processor time of the reduction's thread in functions of the recording
    double longest_step_s = 0;  // of the recorder's thread, including flush and fdatasync
    double longest_add_s = 0;   // longest wait of the reduction's thread
    double worst_behind_s = 0;  // of the feeder against real time: delays caused by the machine
    std::uint64_t lost = 0;     // pieces of data dropped because a queue was full
    std::uint64_t bytes = 0;    // size of the finished file
};

/// Host stamps are the steady clock (CLOCK_MONOTONIC) at the delivery of the data. Throws the exceptions of
/// the recording. The file is finished under its final name.
LiveCost record_live(const std::filesystem::path& file, const LiveStreams& streams);

}  // namespace shaker::test
