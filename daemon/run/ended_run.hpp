#pragma once
// A run that is over: its results, and its recording. A run that a limit stopped leaves the cause, the part
// that was measured before, and the last seconds of all streams.
#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "daemon/acquisition/recent_frames.hpp"
#include "daemon/control/identification.hpp"
#include "daemon/recording/recorder.hpp"
#include "daemon/recording/tables/trip_table.hpp"
#include "daemon/run/sequence.hpp"
#include "drivers/simulated/world.hpp"

namespace shaker::run {

/// The truth of a simulated run.
struct Truth {
    double v_D = 0;  // m/s, over the measured part
    std::vector<std::vector<simulated::PoseTruth>> poses;  // one list a camera, in the views' order
};
Truth truth_of(const simulated::World& world, const std::vector<View>& views,
               const recording::MeasuredPart& part);

/// Everything that results and recording are made from. It refers to nothing that the loops change, so that
/// another thread may finish it.
struct EndedRun {
    recorded::RecordingHeader header;
    double started_s = 0;  // master time of header.started
    acquisition::Streams streams;
    const std::vector<acquisition::RecentFrames>* tails = nullptr;  // held since the trip; null: no trip
    /// The trip that stopped it and those after it, each with the state it came in; empty: no limit stopped
    /// it.
    struct Stop {
        safety::Trip trip;
        RunState state;
    };
    std::vector<Stop> stops;
    recording::MeasuredPart finished;  // the newest finished measurement; empty: none
    recording::MeasuredPart planned;   // the measurement that a limit stopped; empty: none had begun
    std::optional<control::IdentifiedResponse> identified;
    std::vector<std::string> notes;  // for the reader of the results
    std::optional<Truth> truth;
};

/// What stopped the run and what the run was in, without streams. Trips that were excused or cleared before
/// are not among its stops.
EndedRun ended_run(const Sequence& sequence, const acquisition::Streams& streams);

/// The results of a run, or why there are none.
struct Results {
    recording::MeasuredPart part;  // of master time; empty without a reduction
    std::optional<reduction::Reduction> reduction;
    std::string not_reduced;
    std::vector<recording::RecordedTrip> trips;
};

/// Settles the streams' times and reduces the newest finished measurement; without one, the periods of a
/// measurement that were measured well before the first trip.
Results results_of(EndedRun& run);

/// The note on results of so many periods that were measured before a limit stopped the run.
std::string stopped_note(double periods);

/// Completes the recording of the whole run. Where it keeps no frames a stopped run's gets those of the
/// tails. DeviceError when the file cannot be written.
void finish(recording::Recorder& recording, const EndedRun& run, const Results& results);

/// Where a stopped run is not recorded: writes a recording of its last seconds. DeviceError when the file
/// cannot be written.
void record_tail(const EndedRun& run, const Results& results, const std::filesystem::path& file);

/// "trip-20261121T140000Z.nxs" in a folder; "-2" and so on behind the time when there is one already.
std::filesystem::path trip_file(const std::filesystem::path& folder,
                                std::chrono::system_clock::time_point now);

}  // namespace shaker::run
