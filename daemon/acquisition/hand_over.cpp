#include "daemon/acquisition/hand_over.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include "drivers/time.hpp"

namespace shaker::acquisition {

namespace {

constexpr double allowance_s = 1;

// Copies the end of a list, starting after the last element for which `before` is true.
template <class T, class Before>
std::vector<T> end_of(const std::vector<T>& list, Before before) {
    const auto first = std::find_if(list.rbegin(), list.rend(), before).base();
    return {first, list.end()};
}

}  // namespace

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

}  // namespace shaker::acquisition
