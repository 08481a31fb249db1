#pragma once
// What a run leaves behind that a limit stopped: a recording with the cause, what was measured before, and
// the last seconds of all streams.
#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

#include "daemon/control/identification.hpp"
#include "daemon/frame_tail.hpp"
#include "daemon/recording.hpp"
#include "daemon/trip_record.hpp"

namespace shaker {

struct StoppedRun {
    SessionHeader header;
    const Take& take;  // times settled
    const std::vector<FrameTail>& tails;
    std::vector<RecordedTrip> trips;  // at least one
    MeasuredPart planned;             // of the measurement, when one had begun
    const IdentifiedResponse* identified = nullptr;
};

/// Completes the recording of the whole run. Where it keeps no frames it gets those of the tails.
void finish(Recording& recording, const StoppedRun& run);

/// Where there is no recording: writes one of the last seconds. DeviceError when the file cannot be written.
void record_tail(const StoppedRun& run, const std::filesystem::path& file);

/// "trip-20261121T140000Z.nxs" in a folder; "-2" and so on behind the time when there is one already.
std::filesystem::path trip_file(const std::filesystem::path& folder,
                                std::chrono::system_clock::time_point now);

}  // namespace shaker
