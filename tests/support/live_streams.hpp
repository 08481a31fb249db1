#pragma once
// What a whole bench sends to its recording, in real time and without devices, and what recording it costs.
#include <filesystem>

#include "daemon/recording.hpp"

namespace shaker::test {

struct LiveStreams {
    double seconds = 20;
    double dac_rate_hz = 192000;
    std::size_t dac_block = 960;  // 5 ms
    double accelerometer_rate_hz = 50000;
    double frame_rate_hz = 1000;  // of each of two cameras, each with two targets; no pictures
};

struct LiveCost {
    double wall_s = 0;
    double recorder_s = 0;      // processor time of the recorder's thread
    double feeder_s = 0;        // of the reduction's thread in the recording's functions
    double longest_step_s = 0;  // of the recorder's thread, flush and fdatasync included
    double longest_add_s = 0;   // that the reduction's thread was held up
    double worst_behind_s =
        0;                   // of the feeder against real time: what the other figures may owe to the machine
    std::uint64_t lost = 0;  // pieces of data that found no room
    std::uint64_t bytes = 0;  // of the finished file
};

/// Host stamps are those of the steady clock (CLOCK_MONOTONIC), when the data are handed over. Throws what
/// recording throws; the file is finished under its name.
LiveCost record_live(const std::filesystem::path& file, const LiveStreams& streams);

}  // namespace shaker::test
