#include "daemon/service/state_builder.hpp"

#include <algorithm>
#include <cmath>

#include "daemon/acquisition/run_loops.hpp"
#include "daemon/run/run_setup.hpp"
#include "drivers/errors.hpp"

namespace shaker::service {

namespace {

constexpr std::size_t waveform_points = 256;  // over shown_periods
constexpr double shown_periods = 2;

bool asks(run::RunState state) { return state == run::RunState::ramp || state == run::RunState::run; }

const acquisition::TargetTrack* track_named(const acquisition::Streams& streams, const char* name) {
    const auto found = std::ranges::find(streams.tracks, name,
                                         [](const acquisition::TargetTrack& t) { return t.target.name; });
    return found == streams.tracks.end() ? nullptr : &*found;
}

// Shifts the measured motion in time so that the target's first harmonic has the target's phase. The absolute
// phase is no part of a set-point, and the measured one includes the sensor's delay.
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

ClockState clock_state(const std::string& name, const calibration::ClockFit& clock) {
    return {name, clock.ppm, clock.ppm_sigma, clock.delay.count()};
}

}  // namespace

void StateBuilder::feed(const acquisition::Streams& streams) {
    feed_accelerations(streams);
    feed_tracks(streams);
}

void StateBuilder::feed_accelerations(const acquisition::Streams& streams) {
    const control::PeriodWindows& windows = sequence_.windows();
    const Harmonics<Acceleration> target =
        asks(sequence_.state()) ? harmonics(sequence_.controller().drive()) : Harmonics<Acceleration>{};
    const bool silent = target.order() == 0;
    blocks_ = std::max(blocks_, streams.dropped.blocks);
    for (; blocks_ < streams.dropped.blocks + streams.blocks.size(); ++blocks_) {
        if (!streams.timebase.ready()) continue;
        const AccelBlock& b = streams.blocks[blocks_ - streams.dropped.blocks];
        for (int i = 0; i < b.size; ++i) {
            const double t_s = seconds(streams.timebase.at(AccelTick{b.first.n + i}));
            const double measured =
                windows.along(streams.accelerometer.acceleration(b.counts[static_cast<std::size_t>(i)]));
            const double asked = silent ? 0 : value_at(target, two_pi * windows.history().turns(t_s));
            feed_.acceleration.add(t_s, std::array{static_cast<float>(asked), static_cast<float>(measured)});
        }
    }
}

void StateBuilder::feed_tracks(const acquisition::Streams& streams) {
    const acquisition::TargetTrack *walker = track_named(streams, "walker"),
                                   *base = track_named(streams, "base");
    if (base != nullptr && !base->tracks.empty() && found(base->tracks.back().fix.state))
        base_m_ = base->tracks.back().x_m;
    if (walker == nullptr) return;
    walkers_ = std::max(walkers_, walker->dropped);
    for (; walkers_ < walker->dropped + walker->tracks.size(); ++walkers_) {
        const tracking::Track& k = walker->tracks[walkers_ - walker->dropped];
        if (found(k.fix.state) && std::isfinite(seconds(k.time)))
            feed_.track.add(seconds(k.time),
                            std::array{static_cast<float>(k.x_m), static_cast<float>(base_m_)});
    }
}

BaseState StateBuilder::base() const {
    const control::PeriodWindows::Window& w = *sequence_.newest();
    const control::DriveController& controller = sequence_.controller();
    const Harmonics<Acceleration> target =
        asks(sequence_.state()) ? harmonics(controller.drive()) : Harmonics<Acceleration>{};
    const Harmonics<Acceleration> got = aligned(w.estimate.along, target);
    BaseState base;
    base.got = drive_of(w.estimate.along, controller.drive().frequency);
    base.controlled = control::controlled_harmonics;
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

// Two periods of the harmonics of the newest window. The live feed shows the complete signal.
WaveformState StateBuilder::waveform() const {
    const control::PeriodWindows::Window& w = *sequence_.newest();
    const double frequency = sequence_.windows().history().frequency();
    const Harmonics<Acceleration> target =
        asks(sequence_.state()) ? harmonics(sequence_.controller().drive()) : Harmonics<Acceleration>{};
    const Harmonics<Acceleration> got = aligned(w.estimate.along, target);
    WaveformState wave{.t_s = w.from_s, .period_s = 1 / frequency, .asked = {}, .measured = {}};
    for (std::size_t i = 0; i < waveform_points; ++i) {
        const double phase = shown_periods * two_pi * static_cast<double>(i) / waveform_points;
        wave.asked.push_back(static_cast<float>(value_at(target, phase)));
        wave.measured.push_back(static_cast<float>(value_at(got, phase)));
    }
    return wave;
}

std::vector<GaugeState> StateBuilder::gauges(const std::vector<safety::Demand>& predicted,
                                             const safety::Limits& limits) const {
    std::vector<GaugeState> all;
    for (const safety::Demand& d : predicted)
        all.push_back({.quantity = d.quantity, .unit = d.unit, .limit = d.limit, .set_point = d.value});
    if (!sequence_.newest() || !driving(sequence_.state())) return all;
    const control::PeriodWindows::Window& w = *sequence_.newest();
    Harmonics<Acceleration> motion;
    for (std::size_t q = 0; q < control::controlled_harmonics; ++q) motion.a[q] = w.estimate.along.a[q];
    std::vector<safety::Demand> live;
    try {
        live = run::motion_demands(bench_, motion, sequence_.windows().history().frequency(), limits);
    } catch (const InputError&) {  // the data sheet has no response at one of these frequencies
        return all;
    }
    for (GaugeState& g : all)
        for (const safety::Demand& d : live)
            if (g.quantity == d.quantity) g.live = g.quantity == "drive" ? peak_of(w.motion.volts) : d.value;
    return all;
}

std::optional<TrackingState> StateBuilder::tracking() const {
    TrackingState all;
    bool any = false;
    auto camera = bench_.rig.cameras.begin();
    for (const acquisition::TimeHistogram& h : collector_.channels().tracking) {
        const acquisition::TimeHistogram::Seen seen = h.seen();
        const double rate_hz = (*camera++)->view().frame_rate_hz;
        if (seen.total() == 0) continue;
        any = true;
        all.median_s = std::max(all.median_s, acquisition::TimeHistogram::quantile(seen, 0.5));
        all.slowest_s = std::max(all.slowest_s, acquisition::TimeHistogram::quantile(seen, 0.999));
        all.core_share += rate_hz * seen.mean_s();
    }
    return any ? std::optional{all} : std::nullopt;
}

void StateBuilder::fill(BenchState& state, const safety::Limits& limits) const {
    state.limits = limits;
    state.state = sequence_.state();
    state.now_s = sequence_.now_s();
    state.since_s = sequence_.since_s();
    const control::DriveController& controller = sequence_.controller();
    state.locked = state.state == run::RunState::run && controller.report().locked;
    state.reached = controller.report().reached;
    state.measuring = state.state == run::RunState::run && sequence_.to_s() > state.now_s;
    state.trip = sequence_.trip();
    state.trips = sequence_.stops().size();
    if (sequence_.newest()) {
        state.base = base();
        state.waveform = waveform();
    }
    if (const run::WalkerMonitor& walker = sequence_.walker(); walker.x_m())
        state.walker = WalkerState{.x_m = *walker.x_m(),
                                   .edge_m = 1e-3 * walker.edge_mm().value_or(NAN),
                                   .left_m = walker.ends_m()[0],
                                   .right_m = walker.ends_m()[1],
                                   .ways_m = walker.ways_m(limits.edge_mm),
                                   .drift_m = walker.drift_m(),
                                   .lost = walker.lost()};
    const calibration::Timebase& timebase = collector_.streams().timebase;
    state.clocks = {clock_state("dac", timebase.dac()),
                    clock_state("accelerometer", timebase.accelerometer())};
    for (std::size_t i = 0; i < timebase.cameras(); ++i)
        state.clocks.push_back(clock_state(bench_.rig.cameras[i]->view().camera, timebase.camera(i)));
    state.devices = device_reports(bench_.rig);
    const acquisition::Channels& channels = collector_.channels();
    state.lost = {channels.lost.plays_lost,  channels.lost.changes_lost, channels.lost.blocks_lost,
                  channels.lost.frames_lost, channels.lost.trips_lost,   channels.lost.samples_clamped};
    state.jitter = channels.jitter.seen();
    state.tracking = tracking();
    const Rig& rig = bench_.rig;
    if (rig.abort_input) state.contact = channels.contact;
    if (rig.dac->info().enable_before_s > 0) state.enable_output = channels.enabled;
    state.aborts = collector_.streams().aborts;
    for (std::size_t i = 0; i < bench_.rig.cameras.size(); ++i) {
        const acquisition::TrackedFrame& newest = collector_.newest(i);
        const View& view = collector_.views()[i];
        PictureState picture{view.camera,  state.now_s,  newest.frame, 1 / view.mm_per_px,
                             newest.fixes, view.targets, {},           newest.not_found};
        for (std::size_t k = 0; k < view.targets.size(); ++k)
            picture.regions_now.push_back(collector_.region_now(i, k));
        state.pictures_now.push_back(std::move(picture));
    }
}

}  // namespace shaker::service
