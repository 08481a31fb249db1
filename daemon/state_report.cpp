#include "daemon/state_report.hpp"

#include <algorithm>
#include <cmath>

#include "daemon/drive_rig.hpp"

namespace shaker {

namespace {

constexpr std::size_t waveform_points = 256;  // of two periods
constexpr double shown_periods = 2;

bool asks(RunState state) { return state == RunState::ramp || state == RunState::run; }

const TargetTrack* track_named(const Take& take, const char* name) {
    const auto found =
        std::ranges::find(take.tracks, name, [](const TargetTrack& t) { return t.target.name; });
    return found == take.tracks.end() ? nullptr : &*found;
}

// When harmonic 1 has phase 0 is not asked for, and the sensor's delay is in it: the measured motion from the
// instant at which the first harmonic that is asked for has the phase it is asked for with.
Harmonics<Acceleration> aligned(Harmonics<Acceleration> measured, const Harmonics<Acceleration>& target) {
    std::size_t first = 0;
    while (first < max_harmonics && std::abs(target.a[first]) == 0) ++first;
    if (first == max_harmonics || std::abs(measured.a[first]) == 0) return measured;
    const double late = std::arg(measured.a[first] / target.a[first]) / static_cast<double>(first + 1);
    for (std::size_t q = 0; q < max_harmonics; ++q)
        measured.a[q] *= std::polar(1.0, -late * static_cast<double>(q + 1));
    return measured;
}

double peak_of(const Harmonics<Voltage>& volts) {
    double peak = 0;
    for (std::size_t i = 0; i < waveform_points; ++i)
        peak = std::max(peak, std::abs(value_at(volts, two_pi * static_cast<double>(i) / waveform_points)));
    return peak;
}

template <class Clock>
ClockState clock_state(const std::string& name, const ClockTracker<Clock>& clock) {
    return {name, clock.ppm(), clock.ppm_sigma(), clock.residual().count()};
}

}  // namespace

void StateReport::feed(const Take& take) {
    feed_accelerations(take);
    feed_tracks(take);
}

void StateReport::feed_accelerations(const Take& take) {
    const MotionWindows& windows = director_.windows();
    const Harmonics<Acceleration> target =
        asks(director_.state()) ? harmonics(director_.keeper().drive()) : Harmonics<Acceleration>{};
    const bool silent = target.order() == 0;
    blocks_ = std::max(blocks_, take.dropped.blocks);
    for (; blocks_ < take.dropped.blocks + take.blocks.size(); ++blocks_) {
        if (!windows.clock().ready()) continue;
        const AccelBlock& b = take.blocks[blocks_ - take.dropped.blocks];
        for (int i = 0; i < b.size; ++i) {
            const double t_s = seconds(windows.clock().master({b.first.n + i}));
            const double measured =
                windows.along(take.accelerometer.acceleration(b.counts[static_cast<std::size_t>(i)]));
            const double asked = silent ? 0 : value_at(target, two_pi * windows.history().turns(t_s));
            feed_.acceleration.add(t_s, std::array{static_cast<float>(asked), static_cast<float>(measured)});
        }
    }
}

void StateReport::feed_tracks(const Take& take) {
    const TargetTrack *walker = track_named(take, "walker"), *base = track_named(take, "base");
    if (base != nullptr && !base->tracks.empty() && found(base->tracks.back().fix.state))
        base_m_ = base->tracks.back().x_m;
    if (walker == nullptr) return;
    walkers_ = std::max(walkers_, walker->dropped);
    for (; walkers_ < walker->dropped + walker->tracks.size(); ++walkers_) {
        const Track& k = walker->tracks[walkers_ - walker->dropped];
        if (found(k.fix.state) && std::isfinite(seconds(k.time)))
            feed_.track.add(seconds(k.time),
                            std::array{static_cast<float>(k.x_m), static_cast<float>(base_m_)});
    }
}

BaseState StateReport::base() const {
    const MotionWindows::Window& w = *director_.newest();
    const DriveKeeper& keeper = director_.keeper();
    const Harmonics<Acceleration> target =
        asks(director_.state()) ? harmonics(keeper.drive()) : Harmonics<Acceleration>{};
    const Harmonics<Acceleration> got = aligned(w.estimate.along, target);
    BaseState base;
    base.got = drive_of(w.estimate.along, keeper.drive().frequency);
    base.controlled = controlled_harmonics;
    base.volts_peak = peak_of(w.motion.volts);
    base.residual = w.estimate.residual;
    double squares = base.residual * base.residual;
    for (std::size_t q = 0; q < max_harmonics; ++q) {
        base.harmonics[q] = {target.a[q], got.a[q], w.estimate.sd};
        squares += std::norm(w.estimate.along.a[q]) / 2;
    }
    base.rms = std::sqrt(squares);
    return base;
}

// The harmonics of the newest period, over two: what is none of them is told by the live feed.
WaveformState StateReport::waveform() const {
    const MotionWindows::Window& w = *director_.newest();
    const double frequency = director_.windows().history().frequency();
    const Harmonics<Acceleration> target =
        asks(director_.state()) ? harmonics(director_.keeper().drive()) : Harmonics<Acceleration>{};
    const Harmonics<Acceleration> got = aligned(w.estimate.along, target);
    WaveformState wave{.t_s = w.from_s, .period_s = 1 / frequency, .asked = {}, .measured = {}};
    for (std::size_t i = 0; i < waveform_points; ++i) {
        const double phase = shown_periods * two_pi * static_cast<double>(i) / waveform_points;
        wave.asked.push_back(static_cast<float>(value_at(target, phase)));
        wave.measured.push_back(static_cast<float>(value_at(got, phase)));
    }
    return wave;
}

void StateReport::fill(BenchState& state) const {
    state.state = director_.state();
    state.now_s = director_.now_s();
    state.since_s = director_.since_s();
    const DriveKeeper& keeper = director_.keeper();
    state.locked = state.state == RunState::run && keeper.report().locked;
    state.reached = keeper.report().reached;
    state.measuring = state.state == RunState::run && director_.to_s() > state.now_s;
    state.trip = director_.trip();
    state.may_clear = director_.may_clear();
    state.trips = director_.stops().size();
    if (director_.newest()) {
        state.base = base();
        state.waveform = waveform();
    }
    if (const WalkerWatch& walker = director_.walker(); walker.x_m())
        state.walker = WalkerState{*walker.x_m(), 1e-3 * walker.edge_mm().value_or(NAN), walker.lost()};
    const DriveClock& clock = director_.windows().clock();
    state.clocks = {clock_state("dac", clock.dac()), clock_state("accelerometer", clock.accelerometer())};
    state.devices = device_reports(bench_.rig);
    const Lanes& lanes = acquisition_.lanes();
    state.lost = {lanes.lost.plays_lost,  lanes.lost.changes_lost, lanes.lost.blocks_lost,
                  lanes.lost.frames_lost, lanes.lost.trips_lost,   lanes.lost.samples_clamped};
    state.jitter = lanes.jitter.seen();
    state.aborts = acquisition_.take().aborts;
    for (std::size_t i = 0; i < bench_.rig.cameras.size(); ++i) {
        const TrackedFrame& newest = acquisition_.newest(i);
        const View& view = bench_.rig.cameras[i]->view();
        state.pictures_now.push_back(
            {view.camera, state.now_s, newest.frame, 1 / view.mm_per_px, newest.fixes, view.targets});
    }
}

}  // namespace shaker
