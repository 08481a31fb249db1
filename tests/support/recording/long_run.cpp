#include "tests/support/recording/long_run.hpp"

#include <cmath>
#include <random>

#include "calibration/camera/camera_scale.hpp"
#include "daemon/recording/tables/places.hpp"
#include "drivers/errors.hpp"
#include "drivers/simulated/sensor.hpp"
#include "drivers/trigger_train.hpp"
#include "drivers/walker/steady_state.hpp"

namespace shaker::test {
namespace {

walker::WalkerSetting setting_of(const LongRun& run, const simulated::Scene& scene) {
    walker::WalkerSetting s;
    s.frequency = run.drive.frequency;
    s.base = harmonics(run.drive);
    s.g = scene.gravity;
    s.friction = {scene.walker.mu_k, scene.walker.mu_s, 0};
    return s;
}

/// A position along the shaker's axis as a tracker finds it.
tracking::Fix fix_at(const View& view, const Target& target, double x_m, double sd_m) {
    const double m_per_px = 1e-3 * calibration::mm_per_px_at(view, target.offset_mm), px = x_m / m_per_px;
    return {view.along[0] * px, view.along[1] * px, sd_m / m_per_px, tracking::TrackState::ok};
}

void see(LongStreams& out, const LongRun& run, const walker::WalkerLaw& law, double v0, std::size_t camera) {
    const View view = out.streams.cameras[camera].view;
    std::mt19937_64 random{run.seed * 104729 + camera};
    std::normal_distribution<double> noise{0, run.position_noise_m};
    std::bernoulli_distribution lost{run.lost};
    walker::Walker walker{law, v0};
    const auto frames = static_cast<std::int64_t>(run.seconds * view.frame_rate_hz);
    for (std::size_t i = 0; i < view.targets.size(); ++i)
        out.streams.tracks[out.streams.cameras[camera].first_track + i].tracks.reserve(
            static_cast<std::size_t>(frames));
    std::vector<tracking::Fix> fixes(view.targets.size());
    for (std::int64_t k = 0; k < frames; ++k) {
        const double start_s =
            static_cast<double>(TriggerTrain::pulse(k, out.streams.dac_rate_hz, view.frame_rate_hz)) /
            out.streams.dac_rate_hz;
        const double mid_s = start_s + view.trigger_delay_s + view.exposure_s / 2;
        const double turns = mid_s * run.drive.frequency, phase = turns - std::floor(turns);
        while (static_cast<double>(walker.period()) < std::floor(turns)) walker.advance_period();
        const double walker_m = walker.advance_to(phase).x, base_m = law.x_base(two_pi * phase);
        for (std::size_t i = 0; i < fixes.size(); ++i) {
            const bool is_walker = view.targets[i].name == "walker";
            fixes[i] = fix_at(view, view.targets[i], (is_walker ? walker_m : base_m) + noise(random),
                              run.position_noise_m);
            if (is_walker && lost(random)) fixes[i] = {};
        }
        Frame frame;
        frame.tick = {k};
        frame.mid_exposure = master_time(mid_s);
        add_fixes(out.streams, camera, frame, fixes, *frame.mid_exposure);
    }
}

/// One period of the base's acceleration at the DAC's samples.
std::vector<double> one_period(const LongRun& run, double rate_hz) {
    const double samples = rate_hz / run.drive.frequency;
    if (samples != std::floor(samples))
        throw InputError{"a period of " + std::to_string(samples) +
                         " samples of the DAC; it must be a whole number of them"};
    std::vector<double> a(static_cast<std::size_t>(std::lround(samples)));
    const Harmonics<Acceleration> base = harmonics(run.drive);
    for (std::size_t n = 0; n < a.size(); ++n)
        a[n] = value_at(base, two_pi * static_cast<double>(n) / samples);
    return a;
}

void feel(LongStreams& out, const LongRun& run, simulated::AccelerometerModel& sensor) {
    const double rate = out.streams.dac_rate_hz;
    const std::vector<double> a = one_period(run, rate);
    const auto samples = std::llround(run.seconds * rate);
    std::size_t phase = 0;
    for (std::int64_t n = 0; n < samples; ++n) {
        if (const auto block = sensor.step(n, a[phase])) add(out.streams, *block);
        if (++phase == a.size()) phase = 0;
    }
}

void play(LongStreams& out, const LongRun& run, std::size_t block_frames) {
    const double rate = out.streams.dac_rate_hz;
    std::mt19937_64 random{run.seed * 7919 + 5};
    std::exponential_distribution<double> late{1 / run.heard_jitter_s};
    const auto samples = std::llround(run.seconds * rate);
    for (std::int64_t n = 0; n < samples; n += static_cast<std::int64_t>(block_frames))
        add(out.streams,
            PlayTime{{n}, simulated::host_time(static_cast<double>(n) / rate + late(random)), 0});
}

}  // namespace

LongStreams make_long_streams(const LongRun& run) {
    simulated::Scene scene = simulated::paper_scene();
    scene.seed = run.seed;
    simulated::AccelerometerModel sensor{scene};
    LongStreams out;
    recorded::RecordingHeader& h = out.header;
    h.title = "a long run";
    h.kind = "run";
    h.rig = scene_text(scene);
    h.frequency_hz = run.drive.frequency;
    h.dac = {"exact", scene.dac_rate_hz, scene.dac_full_scale_v, 240};
    h.accelerometer = sensor.info();
    h.pictures = recorded::KeptPictures::off;
    out.streams.accelerometer = h.accelerometer;
    out.streams.dac_rate_hz = h.dac.rate_hz;
    for (const simulated::CameraTruth& camera : scene.cameras) {
        h.views.push_back(camera.view);
        out.streams.cameras.push_back(
            {.view = camera.view, .first_track = out.streams.tracks.size(), .untimed = {}});
        for (const Target& target : camera.view.targets)
            out.streams.tracks.push_back({camera.view.camera, target, {}});
    }
    out.streams.timebase = empty_timebase(out.streams);
    const walker::WalkerLaw law{setting_of(run, scene)};
    const walker::SteadyState settled = settle(law);
    out.v_D = settled.v_D;
    out.to_s = run.seconds;
    h.groups = recording::recording_places(h, true);
    for (std::size_t i = 0; i < h.views.size(); ++i) see(out, run, law, settled.v0, i);
    feel(out, run, sensor);
    play(out, run, h.dac.block_frames);
    return out;
}

void record_raw(recording::Recorder& file, const acquisition::Streams& streams) {
    for (const PlayTime& played : streams.played) file.add(played);
    for (const DriveChange& change : streams.changes) file.add(change);
    for (const AccelBlock& block : streams.blocks) file.add(block);
    for (std::size_t i = 0; i < streams.cameras.size(); ++i) {
        for (const tracking::Track& k : streams.tracks[streams.cameras[i].first_track].tracks) {
            Frame frame;
            frame.tick = k.tick;
            frame.mid_exposure = k.time;
            file.add(i, frame, {}, {});
        }
    }
}

}  // namespace shaker::test
