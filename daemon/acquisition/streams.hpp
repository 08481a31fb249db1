#pragma once
// All measured data of a run, unchanged, and their conversion to the input of a reduction.
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "calibration/clocks/exposure_clock.hpp"
#include "calibration/clocks/timebase.hpp"
#include "daemon/reduction/measurement.hpp"
#include "daemon/safety/trip.hpp"
#include "drivers/data.hpp"
#include "drivers/devices.hpp"
#include "drivers/synthesiser.hpp"
#include "tracking/tracker.hpp"

namespace shaker::acquisition {

/// The fixes of one target over a run.
struct TargetTrack {
    std::string camera;
    Target target;
    std::vector<tracking::Track> tracks;
    std::size_t dropped = 0;                 // elements removed from the front by drop_before()
    double exposure_s = 0, scale_error = 0;  // of its camera's view
};

/// An empty track of a target in a view.
TargetTrack track_of(const View& view, const Target& target);

/// The frames of one camera and the index of their tracks.
struct CameraStream {
    View view;
    int width = 0, height = 0;    // px, of the newest frame
    double until_s = 0;           // master time of the newest frame
    std::size_t first_track = 0;  // index of its first target in Streams::tracks
    std::string failure{};        // reason for which it delivers no more; empty: it works
    /// Every frame without a final time, in the order of the tracks.
    std::vector<calibration::FrameStamp> untimed;
    std::size_t dropped = 0;         // frames whose tracks drop_before() has removed
    std::size_t stamps_dropped = 0;  // elements removed from the front of `untimed`
    /// Final times of all frames in `untimed`, s, from settle_times(); empty unless tracks were removed.
    std::vector<double> times_s{};
};

struct Streams {
    AccelerometerInfo accelerometer;  // rate 0: no accelerometer
    std::vector<AccelBlock> blocks;
    std::vector<PlayTime> played;      // empty for footage without a DAC
    std::vector<DriveChange> changes;  // empty for footage without a DAC
    std::vector<safety::Trip> trips;   // in the order of the output's answers; the first is the cause
    std::uint64_t aborts = 0;          // number of aborts whose trips are in `trips`
    double dac_rate_hz = 0;
    std::vector<CameraStream> cameras;
    std::vector<TargetTrack> tracks;
    calibration::Timebase timebase{};  // from all stamps; recorded(): from those since forget()
    std::uint64_t blocks_lost = 0, frames_lost = 0, frames = 0;
    /// Elements removed from the front of each list by drop_before(), and the qualities of removed blocks
    /// since forget().
    struct Dropped {
        std::size_t blocks = 0, played = 0, changes = 0;
        std::size_t clipped = 0, after_gap = 0, late = 0;
    } dropped;
};

/// Empty streams with a track for every target of the cameras.
Streams empty_streams(const Rig& rig);

/// Removes data more than 1 s older than master time `from_s`, from each list in which they are the larger
/// part. The drive in force at from_s is kept.
void drop_before(Streams& streams, double from_s);

/// Removes the stamps of the frames whose tracks drop_before() has removed. A recording needs them for the
/// times of all its frames.
void drop_stamps(Streams& streams);

/// Removes all data except the drive in force, so that the following data start separate streams.
void forget(Streams& streams);

/// A time base without stamps for the devices of these streams.
calibration::Timebase empty_timebase(const Streams& streams);

/// Adds data to the streams and to their time base, live and from a recording.
void add(Streams& streams, const PlayTime& played);
void add(Streams& streams, const AccelBlock& block);
/// Adds a frame's stamps to the time base. Returns its mid-exposure: the frame's own, or by the stamps until
/// now (NaN: not known yet). final: this time is not changed later, and a recording holds it with the frame.
MasterTime add_stamps(Streams& streams, std::size_t camera, const Frame& frame, bool final = false);

/// Adds the fixes of a frame, scaled by the camera's view. `time`: mid-exposure for a frame that does not
/// carry it (NaN: not known yet). `final`: this time is not changed later, and the frame's stamps are not
/// kept.
void add_fixes(Streams& streams, std::size_t camera, const Frame& frame,
               const std::vector<tracking::Fix>& fixes, MasterTime time, bool final = false);

/// Computes position and error in metres along the shaker's axis, if the target was found.
void scale(tracking::Track& track, const View& view, const Target& target);

/// Computes the final times of all frames in `untimed` from all stamps. The result depends only on recorded
/// stamps. Adds a note for a camera whose stamps jumped.
void settle_times(Streams& streams, std::vector<std::string>& notes);

/// Number of blocks of this quality.
std::size_t blocks_with(std::span<const AccelBlock> blocks, Quality flag);

/// Notes on the data for the operator: clipped and late blocks, blocks after a gap, lost data, with removed
/// blocks. One sentence each.
std::vector<std::string> notes_on(const Streams& streams);

/// A part of master time, s.
struct ReadPart {
    double from_s, to_s;
};
/// The part of the streams that measurement_of() reads for the part from from_s to to_s.
ReadPart part_read(const Streams& streams, double frequency_hz, double from_s, double to_s);

/// The input of a reduction. Accelerometer samples of a live run get master time from their arrival stamps,
/// accurate to a fraction of a period; the reduction determines the rest from the common motion. Samples of
/// footage stay on the sensor's own clock. Uses the targets "walker" and "base"; frames in which they are
/// lost are omitted and counted. Contains the part and a margin around it that the reduction reads, so the
/// cost does not grow with the length of the streams.
reduction::Measurement measurement_of(const Streams& streams, double frequency_hz, double from_s,
                                      double to_s);

/// The receiver of a run's streams: a recording, or a test.
/// Receives each piece of data once, in the order in which the collector gathers it. All calls come from the
/// reduction thread and must not wait for a disk when the run is live.
class StreamSink {
public:
    StreamSink() = default;
    StreamSink(const StreamSink&) = delete;
    StreamSink& operator=(const StreamSink&) = delete;
    virtual ~StreamSink() = default;
    virtual void add(const PlayTime& played) = 0;
    virtual void add(const DriveChange& change) = 0;
    virtual void add(const AccelBlock& block) = 0;
    /// A frame and the positions of its targets. `time`: the final mid-exposure time of a frame that does not
    /// carry one; empty while it may still change.
    virtual void add(std::size_t camera, const Frame& frame, std::span<const tracking::Track> tracks,
                     const std::optional<MasterTime>& time) = 0;
};

/// Bytes that a measurement of this length (s) takes with its reduction, which copies the streams.
double memory_of(const Rig& rig, double measured_s);
/// InputError when a measurement of this length (s) does not fit into the available memory, with the longest
/// one that does. A system that does not report its memory allows all.
void require_memory(const Rig& rig, double measured_s);

/// Hands the streams of a finished run to the thread that completes its recording.
/// Moves all gathered data out of `streams` without copying; an hour of streams is a gigabyte. `streams`
/// keeps copies of the data since master time `keep_from_s`, of the drive in force at that time and of all
/// trips, and the time base of the bench. The result has the time base of its own stamps.
Streams hand_over(Streams& streams, double keep_from_s);

}  // namespace shaker::acquisition
