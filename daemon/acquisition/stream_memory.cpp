// What of the streams of a run stays in memory.
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <limits>
#include <span>
#include <string>
#include <utility>

#include "daemon/acquisition/streams.hpp"
#include "drivers/errors.hpp"
#include "drivers/time.hpp"

namespace shaker::acquisition {

namespace {

constexpr double allowance_s = 1;

// Removing the front moves the rest, so it is done only when the rest is shorter than the front.
template <class T>
bool worth_dropping(const std::vector<T>& list, typename std::vector<T>::const_iterator keep) {
    return keep - list.begin() > list.end() - keep;
}
template <class T>
std::size_t drop_front(std::vector<T>& list, typename std::vector<T>::iterator keep) {
    const auto n = keep - list.begin();
    if (!worth_dropping<T>(list, keep)) return 0;
    list.erase(list.begin(), keep);
    return static_cast<std::size_t>(n);
}

void drop_blocks(Streams& streams, std::vector<AccelBlock>::iterator keep) {
    if (!worth_dropping<AccelBlock>(streams.blocks, keep)) return;
    const std::span<const AccelBlock> front{streams.blocks.begin(), keep};
    streams.dropped.clipped += blocks_with(front, Quality::clipped);
    streams.dropped.after_gap += blocks_with(front, Quality::gap);
    streams.dropped.late += blocks_with(front, Quality::late);
    streams.dropped.blocks += drop_front(streams.blocks, keep);
}

// Copies the end of a list, starting after the last element for which `before` is true.
template <class T, class Before>
std::vector<T> end_of(const std::vector<T>& list, Before before) {
    const auto first = std::find_if(list.rbegin(), list.rend(), before).base();
    return {first, list.end()};
}

constexpr double copies = 3;             // growing lists, and the input of the reduction
constexpr double samples_of_block = 16;  // at least, so that this is an upper bound for usual sensors

double available_bytes() {
    std::ifstream in{"/proc/meminfo"};
    for (std::string key, unit; in >> key;) {
        double kib = 0;
        if (!(in >> kib)) break;
        if (key == "MemAvailable:") return 1024 * kib;
        std::getline(in, unit);
    }
    return std::numeric_limits<double>::infinity();
}

}  // namespace

void drop_before(Streams& streams, double from_s) {
    if (streams.played.empty()) return;
    const double from_tick = from_s * streams.dac_rate_hz;
    const double age_s = counted_s(streams.played.back().tick, streams.dac_rate_hz) - from_s;
    streams.dropped.played += drop_front(
        streams.played, std::ranges::lower_bound(streams.played, from_tick, {}, [](const PlayTime& p) {
            return static_cast<double>(p.tick.n);
        }));
    const auto in_force = static_cast<std::ptrdiff_t>(in_force_at(streams.changes, from_tick));
    streams.dropped.changes += drop_front(streams.changes, streams.changes.begin() + in_force);
    if (!streams.blocks.empty()) {
        // Uses the sensor's own count, because its clock may not be known.
        const double newest = static_cast<double>(streams.blocks.back().first.n);
        const double oldest = newest - (age_s + allowance_s) * streams.accelerometer.rate_hz;
        drop_blocks(streams, std::ranges::lower_bound(streams.blocks, oldest, {}, [](const AccelBlock& b) {
                        return static_cast<double>(b.first.n);
                    }));
    }
    std::vector<std::size_t> dropped;  // by track; equal for the targets of a camera
    for (TargetTrack& t : streams.tracks) {
        dropped.push_back(drop_front(
            t.tracks, std::ranges::lower_bound(t.tracks, from_s - allowance_s, {},
                                               [](const tracking::Track& k) { return seconds(k.time); })));
        t.dropped += dropped.back();
    }
    for (CameraStream& c : streams.cameras)
        if (!c.view.targets.empty()) c.dropped += dropped.at(c.first_track);
}

void drop_stamps(Streams& streams) {
    for (CameraStream& c : streams.cameras) {
        const std::size_t n = std::min(c.dropped - c.stamps_dropped, c.untimed.size());
        c.stamps_dropped += drop_front(c.untimed, c.untimed.begin() + static_cast<std::ptrdiff_t>(n));
    }
}

void forget(Streams& streams) {
    const auto drop = [](auto& list, std::size_t keep) {
        const std::size_t n = list.size() - std::min(list.size(), keep);
        list.erase(list.begin(), list.begin() + static_cast<std::ptrdiff_t>(n));
        return n;
    };
    const double tick = streams.played.empty() ? 0 : static_cast<double>(streams.played.back().tick.n);
    streams.dropped.changes +=
        drop(streams.changes, streams.changes.size() - in_force_at(streams.changes, tick));
    streams.dropped.played += drop(streams.played, 0);
    streams.dropped.blocks += drop(streams.blocks, 0);
    streams.dropped.clipped = streams.dropped.after_gap = streams.dropped.late = 0;
    for (TargetTrack& t : streams.tracks) t.dropped += drop(t.tracks, 0);
    for (CameraStream& c : streams.cameras) {
        c.untimed.clear();
        c.dropped = c.stamps_dropped = 0;
    }
    streams.timebase.begin_recording();
}

Streams hand_over(Streams& streams, double keep_from_s) {
    Streams all = std::move(streams);
    calibration::Timebase recorded = all.timebase.end_recording();
    const double from_tick = keep_from_s * all.dac_rate_hz;
    const double newest = all.blocks.empty() ? 0 : static_cast<double>(all.blocks.back().first.n);
    const double age_s =
        all.played.empty() ? 0 : counted_s(all.played.back().tick, all.dac_rate_hz) - keep_from_s;
    const double oldest = newest - (age_s + allowance_s) * all.accelerometer.rate_hz;
    Streams rest{
        .accelerometer = all.accelerometer,
        .blocks =
            end_of(all.blocks, [&](const AccelBlock& b) { return static_cast<double>(b.first.n) < oldest; }),
        .played =
            end_of(all.played, [&](const PlayTime& p) { return static_cast<double>(p.tick.n) < from_tick; }),
        .changes = {all.changes.begin() + static_cast<std::ptrdiff_t>(in_force_at(all.changes, from_tick)),
                    all.changes.end()},
        .trips = all.trips,
        .aborts = all.aborts,
        .dac_rate_hz = all.dac_rate_hz,
        .cameras = all.cameras,
        .tracks = {},
        .timebase = all.timebase,
        .blocks_lost = all.blocks_lost,
        .frames_lost = all.frames_lost,
        .frames = all.frames,
        .dropped = all.dropped};
    for (CameraStream& c : rest.cameras) c.untimed.clear();
    rest.dropped.blocks += all.blocks.size() - rest.blocks.size();
    rest.dropped.played += all.played.size() - rest.played.size();
    rest.dropped.changes += all.changes.size() - rest.changes.size();
    for (const TargetTrack& t : all.tracks) {
        auto end = end_of(
            t.tracks, [&](const tracking::Track& k) { return seconds(k.time) < keep_from_s - allowance_s; });
        const std::size_t dropped = t.dropped + t.tracks.size() - end.size();
        rest.tracks.push_back({t.camera, t.target, std::move(end), dropped, t.exposure_s, t.scale_error});
    }
    all.timebase = std::move(recorded);
    streams = std::move(rest);
    return all;
}

double memory_of(const Rig& rig, double measured_s) {
    double per_s = 0;
    for (const auto& camera : rig.cameras) {
        const View& view = camera->view();
        per_s += view.frame_rate_hz * (static_cast<double>(view.targets.size() * sizeof(tracking::Track)) +
                                       sizeof(calibration::FrameStamp));
    }
    if (rig.accelerometer) per_s += rig.accelerometer->info().rate_hz / samples_of_block * sizeof(AccelBlock);
    if (rig.dac) {
        const DacInfo dac = rig.dac->info();
        per_s += dac.rate_hz / static_cast<double>(dac.block_frames) * sizeof(PlayTime);
    }
    return copies * per_s * measured_s;
}

void require_memory(const Rig& rig, double measured_s) {
    const double needed = memory_of(rig, measured_s), available = available_bytes();
    if (needed <= available) return;
    throw InputError{
        fmt::format("a measurement of {:.0f} s needs {:.1f} GB of memory, {:.1f} GB are available: at most "
                    "{:.0f} s fit; measure fewer periods, or many times by \"shakerd serve\"",
                    measured_s, 1e-9 * needed, 1e-9 * available, measured_s * available / needed)};
}

}  // namespace shaker::acquisition
