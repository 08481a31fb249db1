#include "daemon/acquisition.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "drivers/errors.hpp"

namespace shaker {

Acquisition::Acquisition(Rig& rig, Recording* recording, const std::optional<Limits>& limits,
                         double frequency)
    : rig_{rig},
      recording_{recording},
      lanes_{rig.cameras.size()},
      input_{SampleGuard{rig.accelerometer ? rig.accelerometer->info() : AccelerometerInfo{},
                         rig.dac ? rig.dac->info().rate_hz : 1, limits, frequency}},
      take_{empty_take(rig)},
      dac_clock_{take_.dac_rate_hz} {
    for (const auto& camera : rig.cameras) {
        eyes_.emplace_back(camera->view());
        learned_.push_back({.view = camera->view()});
        frame_clocks_.emplace_back(camera->view(), take_.dac_rate_hz);
    }
    frames_.resize(rig.cameras.size());
    newest_.resize(rig.cameras.size());
}

void Acquisition::record(Recording* recording) {
    recording_ = recording;
    if (recording_ == nullptr) return;
    forget(take_);
    // The drive's state is told by its last change, which the take keeps.
    for (const DriveChange& c : take_.changes) recording_->add(c);
}

std::vector<View> Acquisition::views_now() const {
    std::vector<View> views;
    for (std::size_t i = 0; i < learned_.size(); ++i) {
        View view = learned_[i].view;
        for (std::size_t k = 0; k < view.targets.size(); ++k) {
            Target& target = view.targets[k];
            const bool known = newest_[i].frame != nullptr && !learned_[i].fixes.empty();
            if (!known || !found(newest_[i].fixes[k].state))
                throw InputError{"camera \"" + view.camera + "\", target \"" + target.name +
                                 "\": it is not seen; a recording with pictures begins with all targets"};
            const Fix &now = newest_[i].fixes[k], &then = learned_[i].fixes[k];
            target.roi_px[0] += static_cast<int>(std::lround(now.x_px - then.x_px));
            target.roi_px[1] += static_cast<int>(std::lround(now.y_px - then.y_px));
        }
        views.push_back(std::move(view));
    }
    return views;
}

void Acquisition::learn_anew(const std::vector<View>& views) {
    for (std::size_t i = 0; i < views.size(); ++i) {
        if (!eyes_[i].fresh.push(std::make_shared<ViewTracker>(views[i]))) continue;
        ++learned_[i].wanted;
        learned_[i].view = views[i];
    }
}

void Acquisition::keep_tails() {
    for (const auto& camera : rig_.cameras) tails_.emplace_back(camera->view().frame_rate_hz);
}

bool Acquisition::collect() {
    bool any = false;
    while (const auto played = lanes_.played.pop()) {
        any = true;
        take_.played.push_back(*played);
        follow(dac_clock_, *played);
        if (recording_ != nullptr) recording_->add(*played);
    }
    while (const auto change = lanes_.changes.pop()) {
        any = true;
        take_.changes.push_back(*change);
        if (recording_ != nullptr) recording_->add(*change);
    }
    if (const std::uint64_t releases = lanes_.releases; releases != released_) {
        released_ = releases;
        for (FrameTail& tail : tails_) tail.release();
    }
    take_.aborts = lanes_.aborts_answered;
    while (const auto trip = lanes_.trips.pop()) {
        any = true;
        take_.trips.push_back(*trip);
        for (FrameTail& tail : tails_) tail.hold();
    }
    while (const auto block = lanes_.blocks.pop()) {
        any = true;
        take_.blocks.push_back(*block);
        if (recording_ != nullptr) recording_->add(*block);
    }
    take_.blocks_lost = lanes_.lost.blocks_lost;
    take_.frames_lost = lanes_.lost.frames_lost;
    any = collect_frames() || any;
    if (!take_.played.empty()) lanes_.gathered = take_.played.back().tick.n;
    return any;
}

bool Acquisition::collect_frames() {
    bool any = false;
    std::size_t camera = 0;
    for (Ring<TrackedFrame>& ring : lanes_.frames) {
        while (auto tracked = ring.pop()) {
            any = true;
            const MasterTime time = time_of(camera, *tracked->frame);
            const bool counts = tracked->learned == learned_[camera].wanted;
            note_learned(camera, *tracked);
            if (counts) add_fixes(take_, camera, *tracked->frame, tracked->fixes, time, settles_live_);
            if (counts && recording_ != nullptr)
                recording_->add(camera, *tracked->frame, newest_tracks(camera),
                                settles_live_ ? std::optional{time} : std::nullopt);
            if (!tails_.empty()) tails_[camera].push(*tracked->frame);
            if (settles_live_) newest_[camera] = std::move(*tracked);
        }
        ++camera;
    }
    return any;
}

void Acquisition::note_learned(std::size_t camera, const TrackedFrame& tracked) {
    Learned& learned = learned_[camera];
    if (!learned.fixes.empty() && std::exchange(learned.seen, tracked.learned) == tracked.learned) return;
    learned.fixes = tracked.fixes;
}

std::vector<Track> Acquisition::newest_tracks(std::size_t camera) const {
    const CameraTake& c = take_.cameras[camera];
    std::vector<Track> tracks;
    for (std::size_t i = 0; i < c.view.targets.size(); ++i)
        tracks.push_back(take_.tracks[c.first_track + i].tracks.back());
    return tracks;
}

// Live times are provisional: settle_times() finds them from all stamps.
MasterTime Acquisition::time_of(std::size_t camera, const Frame& frame) {
    if (frame.mid_exposure) return *frame.mid_exposure;
    const FrameStamp stamp{frame.tick, frame.stamp, frame.arrived};
    const std::size_t number = frames_[camera]++;
    frame_clocks_[camera].add(stamp);
    const auto dac = dac_clock_.map();
    return dac ? frame_clocks_[camera].mid_exposure(number, stamp, *dac) : master_time(NAN);
}

std::vector<Loop> Acquisition::sensor_loops() {
    std::vector<Loop> loops;
    if (rig_.accelerometer)
        loops.push_back({"accelerometer", 65, true, [this](std::chrono::milliseconds wait) {
                             return accelerometer_step(input_, *rig_.accelerometer, wait, lanes_);
                         }});
    auto ring = lanes_.frames.begin();
    for (std::size_t i = 0; i < rig_.cameras.size(); ++i, ++ring)
        loops.push_back({"camera " + rig_.cameras[i]->view().camera, 50, true,
                         [this, i, &out = *ring](std::chrono::milliseconds wait) {
                             return camera_step(*rig_.cameras[i], eyes_[i], wait, out, lanes_.lost);
                         }});
    return loops;
}

bool Acquisition::ended() const {
    return (!rig_.accelerometer || rig_.accelerometer->ended()) &&
           std::ranges::all_of(rig_.cameras, [](const auto& c) { return c->ended(); });
}

void read_all(Acquisition& acquisition, const std::function<void()>& each) {
    std::vector<Loop> loops = acquisition.sensor_loops();
    while (!acquisition.ended()) {
        for (Loop& loop : loops) loop.step(std::chrono::milliseconds{0});
        acquisition.collect();
        each();
    }
}

}  // namespace shaker
