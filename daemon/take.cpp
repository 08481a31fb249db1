#include "daemon/take.hpp"

#include <algorithm>
#include <cmath>

#include "calibration/camera_scale.hpp"
#include "daemon/frame_clock.hpp"
#include "drivers/errors.hpp"

namespace shaker {

namespace {

constexpr double allowance_s = 1;

// Losses count in the part that is reduced; positions are cut to it by the reduction.
MotionSeries series_of(const TargetTrack& t, double from_s, double to_s) {
    MotionSeries s;
    s.view = t.camera;
    for (std::vector<double>* list : {&s.t_s, &s.x_m, &s.sd_m}) list->reserve(t.tracks.size());
    for (const Track& k : t.tracks) {
        s.stream_from_s = std::min(s.stream_from_s, seconds(k.time));
        s.stream_to_s = std::max(s.stream_to_s, seconds(k.time));
        if (!std::isfinite(seconds(k.time))) continue;
        if (!found(k.fix.state) || !std::isfinite(k.x_m)) {
            if (seconds(k.time) >= from_s && seconds(k.time) <= to_s) ++s.lost;
            continue;
        }
        s.t_s.push_back(seconds(k.time));
        s.x_m.push_back(k.x_m);
        s.sd_m.push_back(k.sd_m);
    }
    return s;
}

AccelSeries accelerations_of(const Take& take) {
    AccelSeries s;
    s.clock_uncertainty_s = take.accelerometer.clock_uncertainty_s;
    s.shaker_axis = take.accelerometer.shaker_axis;
    const DriveClock clock = drive_clock(take);
    std::size_t samples = 0;
    for (const AccelBlock& b : take.blocks) samples += static_cast<std::size_t>(b.size);
    s.t_s.reserve(samples);
    s.a_mps2.reserve(samples);
    for (const AccelBlock& b : take.blocks) {
        for (int i = 0; i < b.size; ++i) {
            const AccelTick tick{b.first.n + i};
            s.t_s.push_back(take.played.empty() ? take.accelerometer.first_sample_s +
                                                      static_cast<double>(tick.n) / take.accelerometer.rate_hz
                                                : seconds(clock.master(tick)));
            s.a_mps2.push_back(take.accelerometer.acceleration(b.counts[static_cast<std::size_t>(i)]));
        }
    }
    return s;
}

// Moving what is left costs as much as that is long: only when the rest is shorter.
template <class T>
std::size_t drop_front(std::vector<T>& list, typename std::vector<T>::iterator keep) {
    const auto n = keep - list.begin();
    if (n <= list.end() - keep) return 0;
    list.erase(list.begin(), keep);
    return static_cast<std::size_t>(n);
}

}  // namespace

void drop_before(Take& take, double from_s) {
    if (take.played.empty()) return;
    const double from_tick = from_s * take.dac_rate_hz;
    const double age_s = static_cast<double>(take.played.back().tick.n) / take.dac_rate_hz - from_s;
    take.dropped.played += drop_front(take.played, std::ranges::find_if(take.played, [&](const PlayTime& p) {
                                          return static_cast<double>(p.tick.n) >= from_tick;
                                      }));
    auto in_force = std::ranges::find_if(take.changes, [&](const DriveChange& c) {
        return static_cast<double>(c.first.n + c.ramp) > from_tick;
    });
    if (in_force != take.changes.begin()) --in_force;
    take.dropped.changes += drop_front(take.changes, in_force);
    if (!take.blocks.empty()) {
        // By the sensor's own count: which of its samples is the newest is known without any clock.
        const double newest = static_cast<double>(take.blocks.back().first.n);
        const double oldest = newest - (age_s + allowance_s) * take.accelerometer.rate_hz;
        take.dropped.blocks +=
            drop_front(take.blocks, std::ranges::find_if(take.blocks, [&](const AccelBlock& b) {
                           return static_cast<double>(b.first.n) >= oldest;
                       }));
    }
    for (TargetTrack& t : take.tracks)
        t.dropped += drop_front(t.tracks, std::ranges::find_if(t.tracks, [&](const Track& k) {
                                    return seconds(k.time) >= from_s - allowance_s;
                                }));
}

void forget(Take& take) {
    const auto drop = [](auto& list, std::size_t keep) {
        const std::size_t n = list.size() - std::min(list.size(), keep);
        list.erase(list.begin(), list.begin() + static_cast<std::ptrdiff_t>(n));
        return n;
    };
    take.dropped.played += drop(take.played, 0);
    take.dropped.changes += drop(take.changes, 1);
    take.dropped.blocks += drop(take.blocks, 0);
    for (TargetTrack& t : take.tracks) t.dropped += drop(t.tracks, 0);
}

Take empty_take(const Rig& rig) {
    Take take;
    if (rig.accelerometer)
        take.accelerometer = rig.accelerometer->info();
    else
        take.accelerometer.rate_hz = 0;
    if (rig.dac) take.dac_rate_hz = rig.dac->info().rate_hz;
    for (const auto& camera : rig.cameras) {
        take.cameras.push_back({.view = camera->view(), .first_track = take.tracks.size(), .untimed = {}});
        for (const Target& target : camera->view().targets)
            take.tracks.push_back({camera->view().camera, target, {}});
    }
    return take;
}

DriveClock drive_clock(const Take& take) {
    DriveClock clock{take.dac_rate_hz, take.accelerometer.rate_hz};
    for (const PlayTime& p : take.played) clock.add(p);
    for (const AccelBlock& b : take.blocks) clock.add(b);
    return clock;
}

void scale(Track& track, const View& view, const Target& target) {
    if (!found(track.fix.state)) return;
    track.x_m = metres_along(view, target.offset_mm, track.fix.x_px, track.fix.y_px);
    track.sd_m = 1e-3 * mm_per_px_at(view, target.offset_mm) * track.fix.sd_px;
}

void add_fixes(Take& take, std::size_t camera, const Frame& frame, const std::vector<Fix>& fixes,
               MasterTime time, bool final) {
    CameraTake& from = take.cameras.at(camera);
    from.width = frame.width;
    from.height = frame.height;
    if (frame.mid_exposure)
        time = *frame.mid_exposure;
    else if (!final)
        from.untimed.push_back({frame.tick, frame.stamp, frame.arrived});
    if (std::isfinite(seconds(time))) from.until_s = std::max(from.until_s, seconds(time));
    for (std::size_t i = 0; i < fixes.size(); ++i) {
        const Target& target = from.view.targets[i];
        Track track{.tick = frame.tick, .time = time, .fix = fixes[i]};
        scale(track, from.view, target);
        take.tracks[from.first_track + i].tracks.push_back(track);
    }
    ++take.frames;
}

void settle_times(Take& take, std::vector<std::string>& notes) {
    ClockTracker<DacClock> dac{take.dac_rate_hz};
    for (const PlayTime& p : take.played) follow(dac, p);
    for (CameraTake& c : take.cameras) {
        if (c.untimed.empty() || !dac.map()) continue;
        FrameClock clock{c.view, take.dac_rate_hz};
        for (const FrameStamp& f : c.untimed) clock.add(f);
        if (clock.jumps() > 0)
            notes.push_back("camera \"" + c.view.camera + "\": its time stamps jumped " +
                            std::to_string(clock.jumps()) + " times; its clock was found anew after each");
        std::size_t doubtful = 0;
        double before_s = -INFINITY;
        for (std::size_t k = 0; k < c.untimed.size(); ++k) {
            MasterTime time = clock.mid_exposure(k, c.untimed[k], *dac.map());
            if (seconds(time) > before_s) {
                before_s = seconds(time);
            } else {
                time = master_time(NAN);
                ++doubtful;
            }
            for (std::size_t i = 0; i < c.view.targets.size(); ++i)
                take.tracks[c.first_track + i].tracks.at(k).time = time;
        }
        if (doubtful > 0)
            notes.push_back("camera \"" + c.view.camera + "\": " + std::to_string(doubtful) +
                            " frames claim a time that another one has; they are left out");
    }
}

std::vector<std::string> notes_on(const Take& take) {
    std::vector<std::string> notes;
    const auto note = [&](auto count, const std::string& what) {
        if (count > 0) notes.push_back(std::to_string(count) + what);
    };
    const auto blocks_with = [&](Quality flag) {
        return std::ranges::count_if(take.blocks, [&](const AccelBlock& b) { return has(b.quality, flag); });
    };
    note(blocks_with(Quality::clipped),
         " accelerometer blocks hold samples at the end of the sensor's range");
    note(blocks_with(Quality::gap), " accelerometer blocks come after missing samples");
    note(blocks_with(Quality::late), " accelerometer blocks came late");
    note(take.blocks_lost, " accelerometer blocks were lost because the reduction did not keep up");
    note(take.frames_lost, " frames were lost because the reduction did not keep up");
    return notes;
}

Measurement measurement_of(const Take& take, double frequency_hz, double from_s, double to_s) {
    Measurement m;
    m.frequency_hz = frequency_hz;
    m.frequency_is_exact = !take.played.empty();
    m.from_s = from_s;
    m.to_s = to_s;
    m.accelerometer = accelerations_of(take);
    for (const TargetTrack& t : take.tracks) {
        if (t.target.name == "walker") m.walkers.push_back(series_of(t, from_s, to_s));
        if (t.target.name == "base") m.bases.push_back(series_of(t, from_s, to_s));
    }
    return m;
}

}  // namespace shaker
