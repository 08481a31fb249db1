#pragma once
// The sensor side of any rig: devices and trackers on one side of the rings, the gathered Take and the
// recording on the other.
#include <chrono>
#include <deque>
#include <functional>
#include <vector>

#include "daemon/drive_clock.hpp"
#include "daemon/executors.hpp"
#include "daemon/frame_clock.hpp"
#include "daemon/frame_tail.hpp"
#include "daemon/lanes.hpp"
#include "daemon/loops.hpp"
#include "daemon/recording.hpp"
#include "daemon/take.hpp"
#include "drivers/devices.hpp"
#include "tracking/tracker.hpp"

namespace shaker {

class Acquisition {
public:
    /// The rig and the recording (null: there is none) outlive this. limits: what the accelerometer's
    /// samples are held against; none: they are only counted. frequency: of the output's silent start, Hz.
    Acquisition(Rig& rig, Recording* recording, const std::optional<Limits>& limits = {},
                double frequency = 20);

    /// The views with their targets' regions about where those are now, as a recording that is tracked again
    /// from its first picture needs them. InputError naming a target that is not seen.
    [[nodiscard]] std::vector<View> views_now() const;
    /// The targets are learned anew in the next frame of each camera, in these regions; frames before it are
    /// in no take and no recording. Lanes::lost counts those that were not there: their tracker goes on as it
    /// was. Reduction thread.
    void learn_anew(const std::vector<View>& views);
    /// What comes from now on goes there too; null: nowhere. Reduction thread. The take begins anew with it.
    void record(Recording* recording);
    /// From now on a frame's time is final as it comes, and told to the recording: nothing is found again
    /// from all stamps, which a daemon that runs for weeks does not keep.
    void settle_live() noexcept { settles_live_ = true; }
    /// From now on copies of the newest frames are kept, for a trip.
    void keep_tails();
    /// One a camera; empty without keep_tails().
    [[nodiscard]] const std::vector<FrameTail>& tails() const noexcept { return tails_; }
    /// A camera's newest frame, kept out of its pool until the next, and where its targets are; null before
    /// the first. Reduction thread.
    [[nodiscard]] const TrackedFrame& newest(std::size_t camera) const { return newest_[camera]; }
    /// Moves what is in the rings into the take and the file. False when there was nothing. Reduction thread.
    bool collect();
    /// The loops that read the devices: accelerometer, then cameras.
    [[nodiscard]] std::vector<Loop> sensor_loops();
    /// Every device has ended and every ring is empty (reduction thread).
    [[nodiscard]] bool ended() const;
    [[nodiscard]] Take& take() noexcept { return take_; }
    [[nodiscard]] Lanes& lanes() noexcept { return lanes_; }

private:
    bool collect_frames();
    void note_learned(std::size_t camera, const TrackedFrame& tracked);
    [[nodiscard]] std::vector<Track> newest_tracks(std::size_t camera) const;
    [[nodiscard]] MasterTime time_of(std::size_t camera, const Frame& frame);

    Rig& rig_;
    Recording* recording_;
    Lanes lanes_;
    Input input_;
    std::deque<Eye> eyes_;
    Take take_;
    ClockTracker<DacClock> dac_clock_;
    std::vector<FrameClock> frame_clocks_;
    std::vector<std::size_t> frames_;  // a camera, so far
    std::vector<TrackedFrame> newest_;
    struct Learned {
        View view;
        std::uint64_t wanted = 0;  // Eye::learned of the frames that count
        std::uint64_t seen = 0;    // of the newest frame
        std::vector<Fix> fixes{};  // in the frame it learned from
    };
    std::vector<Learned> learned_;
    bool settles_live_ = false;
    std::vector<FrameTail> tails_;
    std::uint64_t released_ = 0;  // Lanes::releases that were answered
};

/// Reads a recorded rig from beginning to end in one thread. each: called after every round.
void read_all(
    Acquisition& acquisition, const std::function<void()>& each = [] {});

}  // namespace shaker
