#pragma once
// Everything measured in one run, as it came, and how it becomes the input of a reduction.
#include <optional>
#include <string>
#include <vector>

#include "calibration/clocks/exposure_clock.hpp"
#include "calibration/clocks/timebase.hpp"
#include "daemon/reduction/measurement.hpp"
#include "daemon/safety/trip.hpp"
#include "drivers/devices.hpp"
#include "drivers/synthesiser.hpp"
#include "tracking/track.hpp"

namespace shaker::acquisition {

/// The fixes of one target over a run.
struct TargetTrack {
    std::string camera;
    Target target;
    std::vector<tracking::Track> tracks;
    std::size_t dropped = 0;  // from the front by drop_before()
};

/// The frames of one camera and which tracks were made of them.
struct CameraStream {
    View view;
    int width = 0, height = 0;    // px, of the newest frame
    double until_s = 0;           // master time of the newest frame
    std::size_t first_track = 0;  // of its targets, in Take::tracks
    std::vector<calibration::FrameStamp>
        untimed;  // every frame, in the order of the tracks; empty when times were told
};

struct Streams {
    AccelerometerInfo accelerometer;  // rate 0: none
    std::vector<AccelBlock> blocks;
    std::vector<PlayTime> played;      // empty for a session without a DAC
    std::vector<DriveChange> changes;  // likewise
    std::vector<safety::Trip> trips;   // as the output answered them; the first is the cause
    std::uint64_t aborts = 0;          // the trips of so many aborts are among them
    double dac_rate_hz = 0;
    std::vector<CameraStream> cameras;
    std::vector<TargetTrack> tracks;
    calibration::Timebase timebase{};  // by all stamps; recorded(): by those since forget()
    std::uint64_t blocks_lost = 0, frames_lost = 0, frames = 0;
    /// From the front of each list by drop_before().
    struct Dropped {
        std::size_t blocks = 0, played = 0, changes = 0;
    } dropped;
};

/// A Take with a track for every target of the cameras.
Streams empty_streams(const Rig& rig);

/// Forgets what is older than `from_s` of master time, a second's allowance kept, when that is most of a
/// list: a daemon runs for weeks. The drive in force then is kept.
void drop_before(Streams& streams, double from_s);

/// Forgets all but the drive that is in force: what comes next begins a take of its own.
void forget(Streams& streams);

/// A time base for the devices of these streams that has no stamps yet.
calibration::Timebase empty_timebase(const Streams& streams);

/// Data enter the streams and their time base together, live and from a recording.
void add(Streams& streams, const PlayTime& played);
void add(Streams& streams, const AccelBlock& block);
/// A frame's stamps enter the time base. Returns its mid-exposure, where the frame does not tell it by the
/// stamps so far (NaN: not known yet). final: that time stays, and a recording holds it with the frame.
MasterTime add_stamps(Streams& streams, std::size_t camera, const Frame& frame, bool final = false);

/// Adds the fixes of a frame of a camera; its view tells the scale. `time`: of mid-exposure where the frame
/// does not tell it, as far as it is known so far (NaN: not yet).
/// `final`: it stays that, whatever later stamps tell, and no stamp is kept.
void add_fixes(Streams& streams, std::size_t camera, const Frame& frame,
               const std::vector<tracking::Fix>& fixes, MasterTime time, bool final = false);

/// A fix in metres along the shaker's axis, where it was found.
void scale(tracking::Track& track, const View& view, const Target& target);

/// Gives every track whose frames did not tell their time the one that all stamps of the take say. What it
/// says depends on the recorded stamps alone.
/// Adds a note for a camera whose stamps jumped.
void settle_times(Streams& streams, std::vector<std::string>& notes);

/// What the operator should know about the data: blocks that were clipped, late or behind a gap, what was
/// lost on the way. One sentence each.
std::vector<std::string> notes_on(const Streams& streams);

/// What a reduction needs. Accelerometer stamps of a live run are put on master time by the arrival stamps
/// (good to a fraction of a period; the reduction finds the rest from the common motion); a recorded
/// session's stay on the sensor's own clock. Targets named "walker" and "base" are used; frames where they
/// are lost are left out and counted. Holds the data of the part and some seconds around it, as much as the
/// reduction reads: the cost does not grow with the length of the streams.
reduction::Measurement measurement_of(const Streams& streams, double frequency_hz, double from_s,
                                      double to_s);

}  // namespace shaker::acquisition
