#pragma once
// A finished run: its results and its recording. A run that a limit stopped leaves the cause, the
// part measured before it, and the last seconds of all streams.
#include <chrono>
#include <cmath>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/acquisition/recent_frames.hpp"
#include "daemon/control/identification.hpp"
#include "daemon/recording/recorder.hpp"
#include "daemon/recording/tables/trip_table.hpp"
#include "daemon/run/sequence.hpp"
#include "drivers/simulated/world.hpp"

namespace shaker::run {

/// The true motion of a simulated run.
struct Truth {
    double v_D = 0;                                        // drift velocity over the measured part, m/s
    std::vector<std::vector<simulated::PoseTruth>> poses;  // one list per camera, in the order of the views
};
Truth truth_of(const simulated::World& world, const std::vector<View>& views,
               const recording::MeasuredPart& part, double frequency_hz);

/// The data from which results and recording are made. The loops change none of them, so another thread may
/// finish the run.
struct EndedRun {
    recorded::RecordingHeader header;
    double started_s = 0;  // master time of header.started
    acquisition::Streams streams;
    const std::vector<acquisition::RecentFrames>* tails = nullptr;  // closed at the trip; null: no trip
    struct Stop {
        safety::Trip trip;
        RunState state;  // when it tripped
    };
    std::vector<Stop> stops;  // the trip that stopped the run and later ones; empty: no limit stopped it
    recording::MeasuredPart finished;  // newest finished measurement; empty: no measurement was finished
    recording::MeasuredPart planned;   // the measurement that did not finish; empty: none had begun
    double data_end_s = NAN;   // master time at which a device failed or the run was interrupted; else NaN
    bool interrupted = false;  // the operator ended the run before a measurement was complete
    std::optional<control::IdentifiedResponse> identified;
    std::vector<std::string> notes;  // for the reader of the results
    std::optional<Truth> truth;
    std::function<void()> progress = [] {};  // called after each step of the completion of its file
};

/// Stops, measurements and notes of the run; its streams stay empty. The stops do not include trips that
/// were cleared.
EndedRun ended_run(const Sequence& sequence, const acquisition::Streams& streams);

/// The results of a run, or the reason why it has no results.
struct Results {
    recording::MeasuredPart part;  // reduced part of master time; empty without a reduction
    std::optional<reduction::Reduction> reduction;
    std::string not_reduced;  // reason; empty with a reduction
    std::vector<recording::RecordedTrip> trips;
};

/// Settles the streams' times and reduces the newest finished measurement. Without a finished measurement, it
/// reduces those periods of the stopped one that lie clearly before the first trip or the failure of a
/// device. recording: of this run; null: the run was not recorded.
Results results_of(EndedRun& run, recording::Recorder* recording = nullptr);

/// Note for results from `periods` periods that were measured before `cause` ("a limit", "a failed device")
/// stopped the run.
std::string stopped_note(std::string_view cause, double periods);

/// Master time up to which every device delivered data, s.
double end_of_data(const acquisition::Streams& streams);

/// Completes the recording of the whole run. A stopped run whose recording keeps no frames gets the frames
/// of the tails. DeviceError when the file cannot be written.
void finish(recording::Recorder& recording, const EndedRun& run, const Results& results);

/// Free space below which the last seconds of a stopped run are written without pictures, bytes.
inline constexpr std::uint64_t least_free_for_tails = std::uint64_t{8} << 30U;

/// Writes a recording of the last seconds of a stopped run that was not recorded. DeviceError when the file
/// cannot be written.
void record_tail(const EndedRun& run, const Results& results, const std::filesystem::path& file);

/// Path "trip-20261121T140000Z.nxs" in the folder. "-2", "-3", ... follow the time while the file exists.
std::filesystem::path trip_file(const std::filesystem::path& folder,
                                std::chrono::system_clock::time_point now);

}  // namespace shaker::run
