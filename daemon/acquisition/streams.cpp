#include "daemon/acquisition/streams.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "calibration/accelerometer/sensor_file.hpp"
#include "calibration/camera/camera_scale.hpp"
#include "drivers/errors.hpp"
#include "drivers/time.hpp"

namespace shaker::acquisition {

namespace {

/// The elements in the part. Searches from the end, where the part of a live run is. Elements without a time
/// (NaN) are treated like their neighbours.
template <class T, class Time>
std::span<const T> within(const std::vector<T>& list, const ReadPart& part, Time time_s) {
    auto end = list.end();
    while (end != list.begin() && time_s(*std::prev(end)) > part.to_s) --end;
    auto begin = end;
    while (begin != list.begin() && !(time_s(*std::prev(begin)) < part.from_s)) --begin;
    return {begin, end};
}

// Counts losses and doubtful places from from_s to to_s only. The reduction cuts the positions to that part.
reduction::MotionSeries series_of(const TargetTrack& t, const ReadPart& read, double from_s, double to_s) {
    reduction::MotionSeries s;
    s.view = t.camera;
    const auto tracks = within(t.tracks, read, [](const tracking::Track& k) { return seconds(k.time); });
    const auto counts = [&](const tracking::Track& k) {
        return seconds(k.time) >= from_s && seconds(k.time) <= to_s;
    };
    int places = 0;
    for (const tracking::Track& k : tracks) {
        if (!counts(k)) continue;
        using tracking::TrackState;
        const TrackState state = k.fix.state;
        const bool shown = found(state) && std::isfinite(k.x_m);
        s.lost += !shown;
        s.repeated += state == TrackState::repeated;
        places += shown;
        s.doubtful += shown && doubtful(state);
        s.clipped += shown && state == TrackState::clipped;
        s.slipped += shown && state == TrackState::slipped;
    }
    s.with_doubtful = 2 * s.doubtful > places;
    for (std::vector<double>* list : {&s.t_s, &s.x_m, &s.sd_m}) list->reserve(tracks.size());
    for (const tracking::Track& k : tracks) {
        s.stream_from_s = std::min(s.stream_from_s, seconds(k.time));
        s.stream_to_s = std::max(s.stream_to_s, seconds(k.time));
        if (!std::isfinite(seconds(k.time))) continue;
        if (!found(k.fix.state) || !std::isfinite(k.x_m)) continue;
        if (doubtful(k.fix.state) && !s.with_doubtful) continue;
        s.t_s.push_back(seconds(k.time));
        s.x_m.push_back(k.x_m);
        s.sd_m.push_back(k.sd_m);
    }
    return s;
}

reduction::AccelSeries accelerations_of(const Streams& streams, const ReadPart& read) {
    reduction::AccelSeries s;
    s.clock_uncertainty_s = streams.accelerometer.clock_uncertainty_s;
    s.shaker_axis = streams.accelerometer.shaker_axis;
    s.axes = streams.accelerometer.axes;
    s.gravity = streams.accelerometer.gravity;
    s.response = streams.accelerometer.response;
    s.dac_clock = streams.accelerometer.dac_clock;
    if (const std::string& text = streams.accelerometer.calibration; !text.empty())
        s.calibration = calibration::parse_calibration(text, "the accelerometer's calibration").fit;
    const calibration::Timebase& timebase = streams.timebase.recorded();
    const auto blocks =
        within(streams.blocks, read, [&](const AccelBlock& b) { return seconds(timebase.at(b.first)); });
    std::size_t samples = 0;
    for (const AccelBlock& b : blocks) samples += static_cast<std::size_t>(b.size);
    s.t_s.reserve(samples);
    s.a_mps2.reserve(samples);
    for (const AccelBlock& b : blocks) {
        for (int i = 0; i < b.size; ++i) {
            s.t_s.push_back(seconds(timebase.at(AccelTick{b.first.n + i})));
            s.a_mps2.push_back(streams.accelerometer.acceleration(b.counts[static_cast<std::size_t>(i)]));
        }
    }
    return s;
}

}  // namespace

std::size_t blocks_with(std::span<const AccelBlock> blocks, Quality flag) {
    return static_cast<std::size_t>(
        std::ranges::count_if(blocks, [&](const AccelBlock& b) { return has(b.quality, flag); }));
}

TargetTrack track_of(const View& view, const Target& target) {
    return {.camera = view.camera,
            .target = target,
            .tracks = {},
            .exposure_s = view.exposure_s,
            .scale_error = view.scale_error};
}

Streams empty_streams(const Rig& rig) {
    Streams streams;
    if (rig.accelerometer)
        streams.accelerometer = rig.accelerometer->info();
    else
        streams.accelerometer.rate_hz = 0;
    if (rig.dac) streams.dac_rate_hz = rig.dac->info().rate_hz;
    for (const auto& camera : rig.cameras) {
        streams.cameras.push_back(
            {.view = camera->view(), .first_track = streams.tracks.size(), .untimed = {}});
        for (const Target& target : camera->view().targets)
            streams.tracks.push_back(track_of(camera->view(), target));
    }
    streams.timebase = empty_timebase(streams);
    return streams;
}

calibration::Timebase empty_timebase(const Streams& streams) {
    calibration::TimebaseDevices devices{.dac_rate_hz = streams.dac_rate_hz,
                                         .accelerometer_rate_hz = streams.accelerometer.rate_hz,
                                         .first_sample_s = streams.accelerometer.first_sample_s,
                                         .dac_clock = streams.accelerometer.dac_clock,
                                         .cameras = {}};
    for (const CameraStream& c : streams.cameras) devices.cameras.push_back(c.view);
    return calibration::Timebase{devices};
}

void add(Streams& streams, const PlayTime& played) {
    streams.played.push_back(played);
    streams.timebase.add(played);
}

void add(Streams& streams, const AccelBlock& block) {
    streams.blocks.push_back(block);
    streams.timebase.add(block);
}

MasterTime add_stamps(Streams& streams, std::size_t camera, const Frame& frame, bool final) {
    const calibration::FrameStamp stamp{frame.tick, frame.stamp, frame.arrived};
    using FrameTime = calibration::Timebase::FrameTime;
    if (frame.mid_exposure) {
        streams.timebase.add(camera, stamp, FrameTime::frame);
        return *frame.mid_exposure;
    }
    streams.timebase.add(camera, stamp, final ? FrameTime::stamps_so_far : FrameTime::all_stamps);
    return streams.timebase.mid_exposure(camera, streams.timebase.frames(camera) - 1, stamp);
}

void scale(tracking::Track& track, const View& view, const Target& target) {
    if (!found(track.fix.state)) return;
    track.x_m = calibration::metres_along(view, target.offset_mm, track.fix.x_px, track.fix.y_px);
    track.sd_m = 1e-3 * calibration::mm_per_px_at(view, target.offset_mm, track.fix.x_px, track.fix.y_px) *
                 track.fix.sd_px;
}

void add_fixes(Streams& streams, std::size_t camera, const Frame& frame,
               const std::vector<tracking::Fix>& fixes, MasterTime time, bool final) {
    CameraStream& from = streams.cameras.at(camera);
    from.width = frame.width;
    from.height = frame.height;
    if (frame.mid_exposure)
        time = *frame.mid_exposure;
    else if (!final)
        from.untimed.push_back({frame.tick, frame.stamp, frame.arrived});
    if (std::isfinite(seconds(time))) from.until_s = std::max(from.until_s, seconds(time));
    for (std::size_t i = 0; i < fixes.size(); ++i) {
        const Target& target = from.view.targets[i];
        tracking::Track track{.tick = frame.tick, .time = time, .fix = fixes[i]};
        scale(track, from.view, target);
        streams.tracks[from.first_track + i].tracks.push_back(track);
    }
    ++streams.frames;
}

void settle_times(Streams& streams, std::vector<std::string>& notes) {
    streams.timebase.settle();
    for (std::size_t camera = 0; camera < streams.cameras.size(); ++camera) {
        CameraStream& c = streams.cameras[camera];
        if (c.untimed.empty() || !streams.timebase.dac_ready()) continue;
        if (const std::size_t jumps = streams.timebase.camera(camera).jumps; jumps > 0)
            notes.push_back("camera \"" + c.view.camera + "\": its time stamps jumped " +
                            std::to_string(jumps) + " times; its clock was fitted again after each jump");
        std::size_t doubtful = 0;
        double before_s = -INFINITY;
        for (std::size_t k = 0; k < c.untimed.size(); ++k) {
            const std::size_t number = c.stamps_dropped + k;
            MasterTime time = streams.timebase.mid_exposure(camera, number, c.untimed[k]);
            if (seconds(time) > before_s) {
                before_s = seconds(time);
            } else {
                time = master_time(NAN);
                ++doubtful;
            }
            if (c.dropped > 0) c.times_s.push_back(seconds(time));
            if (number < c.dropped) continue;
            for (std::size_t i = 0; i < c.view.targets.size(); ++i)
                streams.tracks[c.first_track + i].tracks.at(number - c.dropped).time = time;
        }
        if (doubtful > 0)
            notes.push_back("camera \"" + c.view.camera + "\": " + std::to_string(doubtful) +
                            " frames have the time of another frame; they are omitted");
    }
}

std::vector<std::string> notes_on(const Streams& streams) {
    std::vector<std::string> notes;
    const auto note = [&](auto count, const std::string& what) {
        if (count > 0) notes.push_back(std::to_string(count) + what);
    };
    const Streams::Dropped& dropped = streams.dropped;
    note(dropped.clipped + blocks_with(streams.blocks, Quality::clipped),
         " accelerometer blocks have samples at the end of the sensor's range");
    note(dropped.after_gap + blocks_with(streams.blocks, Quality::gap),
         " accelerometer blocks come after missing samples");
    note(dropped.late + blocks_with(streams.blocks, Quality::late), " accelerometer blocks arrived late");
    note(streams.blocks_lost, " accelerometer blocks were lost because the reduction did not keep up");
    note(streams.frames_lost, " frames were lost because the reduction did not keep up");
    return notes;
}

// The margin covers all data that the reduction reads. The accelerometer's clock is uncertain, and the common
// motion shifts it by up to half a period.
ReadPart part_read(const Streams& streams, double frequency_hz, double from_s, double to_s) {
    constexpr double rate_error = 1e-3;  // largest relative error of the accelerometer's clock
    const double margin_s =
        1 + streams.accelerometer.clock_uncertainty_s + 2 / frequency_hz + rate_error * (to_s - from_s);
    return {from_s - margin_s, to_s + margin_s};
}

reduction::Measurement measurement_of(const Streams& streams, double frequency_hz, double from_s,
                                      double to_s) {
    reduction::Measurement m;
    m.frequency_hz = frequency_hz;
    m.frequency_is_exact = !streams.played.empty();
    m.from_s = from_s;
    m.to_s = to_s;
    const ReadPart read = part_read(streams, frequency_hz, from_s, to_s);
    m.accelerometer = accelerations_of(streams, read);
    for (const TargetTrack& t : streams.tracks) {
        std::vector<reduction::MotionSeries>* const to = t.target.name == "walker" ? &m.walkers
                                                         : t.target.name == "base" ? &m.bases
                                                                                   : nullptr;
        if (to == nullptr) continue;
        reduction::MotionSeries& s = to->emplace_back(series_of(t, read, from_s, to_s));
        s.exposure_s = t.exposure_s;
        s.scale_error = t.scale_error;
    }
    return m;
}

}  // namespace shaker::acquisition
