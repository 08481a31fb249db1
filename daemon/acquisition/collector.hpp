#pragma once
// The sensor side of any rig: devices and trackers write into rings; the collector moves the data from the
// rings to the streams and the recording.
#include <array>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "daemon/acquisition/channels.hpp"
#include "daemon/acquisition/executors.hpp"
#include "daemon/acquisition/moved_targets.hpp"
#include "daemon/acquisition/recent_frames.hpp"
#include "daemon/acquisition/steps.hpp"
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

    /// The views with the regions in force: those of the cameras, or of move_targets().
    [[nodiscard]] const std::vector<View>& views() const noexcept { return views_; }
    /// Puts these regions in force: learns the targets of their cameras in the newest pictures, and tracks
    /// these from the next picture on. Targets that are not named are learned at their present places.
    /// InputError names camera, target and region when a number is wrong or a target is not found; then
    /// nothing changes. Reduction thread, with settle_live().
    void move_targets(std::span<const MovedTarget> moved);
    /// A target's region moved to its present position; empty: the target is not visible.
    [[nodiscard]] std::optional<std::array<int, 4>> region_now(std::size_t camera, std::size_t target) const;
    /// The views with the regions of their targets moved to the present positions. A recording whose pictures
    /// will be tracked again needs these regions. InputError naming a target that is not visible.
    [[nodiscard]] std::vector<View> views_now() const;
    /// Learns the targets again in these regions, in the next frame of each camera. Streams and recording
    /// omit the frames before it. A tracker that does not find its targets is counted in Channels::lost, and
    /// the previous tracker continues. Reduction thread.
    void relearn(const std::vector<View>& views);
    /// Sends all following data also to `sink`; null: stops that. The streams start again. Reduction thread.
    void record(StreamSink* sink);
    /// From now on the time of each frame is final when it arrives, and is recorded. For a daemon that runs
    /// for weeks and does not keep all stamps. Frames in which the targets are not found yet are counted in
    /// no stream; newest() has the reason.
    void settle_live() noexcept;
    /// From now on copies of the newest frames are kept for the recording of a trip.
    void keep_tails();
    /// Leaves the tails unchanged until the trip is released, so that another thread can read them.
    void close_tails() noexcept { tails_closed_ = true; }
    /// One per camera; empty without keep_tails().
    [[nodiscard]] const std::vector<RecentFrames>& tails() const noexcept { return tails_; }
    /// A camera's newest frame, kept out of its pool until the next one, with the positions of its targets;
    /// null before the first. Reduction thread.
    [[nodiscard]] const TrackedFrame& newest(std::size_t camera) const { return newest_[camera]; }
    /// Moves data from the rings to streams and recording. False when all rings were empty. Reduction thread.
    bool collect();
    /// The loops that read the devices: accelerometer, then cameras.
    [[nodiscard]] std::vector<Loop> sensor_loops();
    /// True when every device has ended. Reduction thread.
    [[nodiscard]] bool ended() const;
    [[nodiscard]] Streams& streams() noexcept { return streams_; }
    [[nodiscard]] Channels& channels() noexcept { return channels_; }

private:
    bool collect_frames();
    void take_tracker(std::size_t camera, std::shared_ptr<tracking::ViewTracker> tracker, const View& view);
    void note_learned(std::size_t camera, const TrackedFrame& tracked);
    [[nodiscard]] std::vector<tracking::Track> newest_tracks(std::size_t camera) const;

    Rig& rig_;
    StreamSink* sink_;
    Channels channels_;
    AccelerometerInput input_;
    std::deque<CameraInput> camera_inputs_;
    Streams streams_;
    std::vector<View> views_;  // see views()
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

/// Reads a recorded rig from start to end in one thread.
void read_all(Collector& collector);

}  // namespace shaker::acquisition
