#pragma once
// The sensor side of any rig: devices and trackers write into rings; the collector moves the data from the
// rings to the streams and the recording.
#include <chrono>
#include <deque>
#include <functional>
#include <vector>

#include "daemon/acquisition/channels.hpp"
#include "daemon/acquisition/executors.hpp"
#include "daemon/acquisition/recent_frames.hpp"
#include "daemon/acquisition/steps.hpp"
#include "daemon/acquisition/stream_sink.hpp"
#include "daemon/acquisition/streams.hpp"
#include "drivers/devices.hpp"
#include "tracking/tracker.hpp"

namespace shaker::acquisition {

class Collector {
public:
    /// Rig and recording (null: no recording) must outlive this object. limits: for the accelerometer's
    /// samples; empty: samples are counted, not checked. frequency: of the output's silent start, Hz.
    Collector(Rig& rig, StreamSink* sink, const std::optional<safety::Limits>& limits = {},
              double frequency = 20);

    /// The views with their targets' regions about where those are now, as a recording that is tracked again
    /// from its first picture needs them. InputError naming a target that is not seen.
    [[nodiscard]] std::vector<View> views_now() const;
    /// The targets are learned anew in the next frame of each camera, in these regions; frames before it are
    /// in no take and no recording. Channels::lost counts those that were not there: their tracker goes on as
    /// it was. Reduction thread.
    void relearn(const std::vector<View>& views);
    /// What comes from now on goes there too; null: nowhere. Reduction thread. The take begins anew with it.
    void record(StreamSink* sink);
    /// From now on a frame's time is final as it comes, and told to the recording: nothing is found again
    /// from all stamps, which a daemon that runs for weeks does not keep.
    void settle_live() noexcept { settles_live_ = true; }
    /// From now on copies of the newest frames are kept, for a trip.
    void keep_tails();
    /// What the tails hold stays as it is, for another thread to read, until the trip is released.
    void close_tails() noexcept { tails_closed_ = true; }
    /// One a camera; empty without keep_tails().
    [[nodiscard]] const std::vector<RecentFrames>& tails() const noexcept { return tails_; }
    /// A camera's newest frame, kept out of its pool until the next, and where its targets are; null before
    /// the first. Reduction thread.
    [[nodiscard]] const TrackedFrame& newest(std::size_t camera) const { return newest_[camera]; }
    /// Moves what is in the rings into the take and the file. False when there was nothing. Reduction thread.
    bool collect();
    /// The loops that read the devices: accelerometer, then cameras.
    [[nodiscard]] std::vector<Loop> sensor_loops();
    /// Every device has ended and every ring is empty (reduction thread).
    [[nodiscard]] bool ended() const;
    [[nodiscard]] Streams& streams() noexcept { return streams_; }
    [[nodiscard]] Channels& channels() noexcept { return channels_; }

private:
    bool collect_frames();
    void note_learned(std::size_t camera, const TrackedFrame& tracked);
    [[nodiscard]] std::vector<tracking::Track> newest_tracks(std::size_t camera) const;

    Rig& rig_;
    StreamSink* sink_;
    Channels channels_;
    AccelerometerInput input_;
    std::deque<CameraInput> camera_inputs_;
    Streams streams_;
    std::vector<TrackedFrame> newest_;
    struct Learned {
        View view;
        std::uint64_t wanted = 0;            // CameraInput::learned of the frames to be kept
        std::uint64_t seen = 0;              // CameraInput::learned of the newest frame
        std::vector<tracking::Fix> fixes{};  // in the frame in which the targets were learned
    };
    std::vector<Learned> learned_;
    bool settles_live_ = false;
    std::vector<RecentFrames> tails_;
    bool tails_closed_ = false;
    std::uint64_t released_ = 0;  // value of Channels::releases that was answered
};

/// Reads a recorded rig from start to end in one thread. each: called after every round.
void read_all(
    Collector& collector, const std::function<void()>& each = [] {});

}  // namespace shaker::acquisition
