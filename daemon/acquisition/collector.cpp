#include "daemon/acquisition/collector.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <utility>

#include "drivers/errors.hpp"
#include "drivers/realtime.hpp"

namespace shaker::acquisition {

Collector::Collector(Rig& rig, StreamSink* sink, const std::optional<safety::Limits>& limits,
                     double frequency)
    : rig_{rig},
      sink_{sink},
      channels_{rig.cameras.size()},
      input_{safety::SampleGuard{rig.accelerometer ? rig.accelerometer->info() : AccelerometerInfo{},
                                 rig.dac ? rig.dac->info().rate_hz : 1, limits, frequency}},
      streams_{empty_streams(rig)} {
    for (const auto& camera : rig.cameras) {
        camera_inputs_.emplace_back(camera->view());
        learned_.push_back({.view = camera->view()});
        views_.push_back(camera->view());
    }
    newest_.resize(rig.cameras.size());
}

void Collector::record(StreamSink* sink) {
    sink_ = sink;
    if (sink_ == nullptr) return;
    forget(streams_);
    // The streams keep the changes from which the drive follows.
    for (const DriveChange& c : streams_.changes) sink_->add(c);
}

void Collector::settle_live() noexcept {
    settles_live_ = true;
    for (CameraInput& input : camera_inputs_) input.patient = true;
}

std::optional<std::array<int, 4>> Collector::region_now(std::size_t camera, std::size_t target) const {
    const Learned& learned = learned_[camera];
    const TrackedFrame& newest = newest_[camera];
    if (newest.frame == nullptr || learned.fixes.empty() || !found(newest.fixes[target].state)) return {};
    const tracking::Fix &now = newest.fixes[target], &then = learned.fixes[target];
    std::array<int, 4> roi = learned.view.targets[target].roi_px;
    roi[0] += static_cast<int>(std::lround(now.x_px - then.x_px));
    roi[1] += static_cast<int>(std::lround(now.y_px - then.y_px));
    return roi;
}

std::vector<View> Collector::views_now() const {
    std::vector<View> views;
    for (std::size_t i = 0; i < learned_.size(); ++i) {
        View view = learned_[i].view;
        for (std::size_t k = 0; k < view.targets.size(); ++k) {
            const auto roi = region_now(i, k);
            if (!roi)
                throw InputError{
                    "camera \"" + view.camera + "\", target \"" + view.targets[k].name +
                    "\": not visible; a recording with pictures can start only while all targets "
                    "are visible"};
            view.targets[k].roi_px = *roi;
        }
        views.push_back(std::move(view));
    }
    return views;
}

void Collector::relearn(const std::vector<View>& views) {
    for (std::size_t i = 0; i < views.size(); ++i)
        take_tracker(i, std::make_shared<tracking::ViewTracker>(views[i]), views[i]);
}

void Collector::take_tracker(std::size_t camera, std::shared_ptr<tracking::ViewTracker> tracker,
                             const View& view) {
    if (!camera_inputs_[camera].fresh.push(std::move(tracker))) return;
    ++learned_[camera].wanted;
    learned_[camera].view = view;
}

void Collector::move_targets(std::span<const MovedTarget> moved) {
    std::vector<View> views = with_regions(views_, moved);
    std::vector<std::shared_ptr<tracking::ViewTracker>> trackers(views.size());
    std::vector<View> learned = views;
    for (std::size_t i = 0; i < views.size(); ++i) {
        const auto named = [&](const std::string& target) {
            return std::ranges::any_of(moved, [&](const MovedTarget& m) {
                return m.camera == views[i].camera && (target.empty() || m.target == target);
            });
        };
        if (!named({})) continue;
        const std::string who = "camera \"" + views[i].camera + "\": ";
        if (views[i].positions)
            throw InputError{who + "gives positions instead of pictures; its targets have no regions"};
        if (newest_[i].frame == nullptr || camera_inputs_[i].fresh.full())
            throw InputError{who + "no new picture has arrived; give the order again when the picture moves"};
        for (std::size_t k = 0; k < views[i].targets.size(); ++k)
            if (const auto now = region_now(i, k); now && !named(views[i].targets[k].name))
                learned[i].targets[k].roi_px = *now;
        trackers[i] = std::make_shared<tracking::ViewTracker>(learned[i]);
        static_cast<void>(trackers[i]->update(newest_[i].frame->view(), newest_[i].frame->tick));
    }
    for (std::size_t i = 0; i < views.size(); ++i)
        if (trackers[i]) take_tracker(i, std::move(trackers[i]), learned[i]);
    views_ = std::move(views);
}

void Collector::keep_tails() {
    for (const auto& camera : rig_.cameras) tails_.emplace_back(camera->view().frame_rate_hz);
}

bool Collector::collect() {
    bool any = false;
    while (const auto played = channels_.played.pop()) {
        any = true;
        add(streams_, *played);
        if (sink_ != nullptr) sink_->add(*played);
    }
    while (const auto change = channels_.changes.pop()) {
        any = true;
        streams_.changes.push_back(*change);
        if (sink_ != nullptr) sink_->add(*change);
    }
    if (const std::uint64_t releases = channels_.releases; releases != released_) {
        released_ = releases;
        for (RecentFrames& tail : tails_) tail.release();
        tails_closed_ = false;
    }
    streams_.aborts = channels_.aborts_answered;
    while (const auto trip = channels_.trips.pop()) {
        any = true;
        streams_.trips.push_back(*trip);
        for (RecentFrames& tail : tails_) tail.hold();
    }
    while (const auto block = channels_.blocks.pop()) {
        any = true;
        add(streams_, *block);
        if (sink_ != nullptr) sink_->add(*block);
    }
    streams_.blocks_lost = channels_.lost.blocks_lost;
    streams_.frames_lost = channels_.lost.frames_lost;
    any = collect_frames() || any;
    if (!streams_.played.empty()) channels_.gathered = streams_.played.back().tick.n;
    return any;
}

bool Collector::collect_frames() {
    bool any = false;
    std::size_t camera = 0;
    for (Ring<TrackedFrame>& ring : channels_.frames) {
        while (auto tracked = ring.pop()) {
            any = true;
            // Unless settles_live_, this time is provisional and settle_times() computes the final one.
            const MasterTime time = add_stamps(streams_, camera, *tracked->frame, settles_live_);
            const bool found = tracked->not_found.empty();
            const bool counts = found && tracked->learned == learned_[camera].wanted;
            if (found) note_learned(camera, *tracked);
            if (counts) add_fixes(streams_, camera, *tracked->frame, tracked->fixes, time, settles_live_);
            if (counts && sink_ != nullptr)
                sink_->add(camera, *tracked->frame, newest_tracks(camera),
                           settles_live_ ? std::optional{time} : std::nullopt);
            if (!tails_.empty() && !tails_closed_) tails_[camera].push(*tracked->frame);
            if (settles_live_) newest_[camera] = std::move(*tracked);
        }
        ++camera;
    }
    camera = 0;
    for (const LoopFailure& failure : channels_.cameras_failed) {
        if (failure.failed) streams_.cameras[camera].failure = failure.why;
        ++camera;
    }
    return any;
}

void Collector::note_learned(std::size_t camera, const TrackedFrame& tracked) {
    Learned& learned = learned_[camera];
    if (!learned.fixes.empty() && std::exchange(learned.seen, tracked.learned) == tracked.learned) return;
    learned.fixes = tracked.fixes;
}

std::vector<tracking::Track> Collector::newest_tracks(std::size_t camera) const {
    const CameraStream& c = streams_.cameras[camera];
    std::vector<tracking::Track> tracks;
    for (std::size_t i = 0; i < c.view.targets.size(); ++i)
        tracks.push_back(streams_.tracks[c.first_track + i].tracks.back());
    return tracks;
}

namespace {

// A run survives a camera that has failed. False when there was no frame.
bool survives(LoopFailure& failure, const std::function<bool()>& step) {
    if (failure.failed) return false;
    try {
        return step();
    } catch (const DeviceError& e) {
        failure.why = e.what();
        failure.failed = true;
        return false;
    }
}

}  // namespace

std::vector<Loop> Collector::sensor_loops() {
    std::vector<Loop> loops;
    if (rig_.accelerometer)
        loops.push_back(
            {"accelerometer", fifo_priority::accelerometer, true, [this](std::chrono::milliseconds wait) {
                 return accelerometer_step(input_, *rig_.accelerometer, wait, channels_);
             }});
    constexpr double camera_share = 0.6;
    auto ring = channels_.frames.begin();
    auto failure = channels_.cameras_failed.begin();
    auto tracking = channels_.tracking.begin();
    for (std::size_t i = 0; i < rig_.cameras.size(); ++i, ++ring, ++failure, ++tracking)
        loops.push_back(
            {"camera " + rig_.cameras[i]->view().camera, fifo_priority::camera, false,
             [this, i, &out = *ring, &lost = *failure, &took = *tracking](std::chrono::milliseconds wait) {
                 return survives(lost, [&] {
                     return camera_step(*rig_.cameras[i], camera_inputs_[i], wait, out, channels_.lost, took);
                 });
             },
             camera_share});
    return loops;
}

bool Collector::ended() const {
    return (!rig_.accelerometer || rig_.accelerometer->ended()) &&
           std::ranges::all_of(rig_.cameras, [](const auto& c) { return c->ended(); });
}

void read_all(Collector& collector) {
    std::vector<Loop> loops = collector.sensor_loops();
    while (!collector.ended()) {
        for (Loop& loop : loops) loop.step(std::chrono::milliseconds{0});
        collector.collect();
    }
}

}  // namespace shaker::acquisition
