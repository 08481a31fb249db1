#include "daemon/run/sequence.hpp"

#include <spdlog/fmt/fmt.h>

#include <numbers>
#include <utility>

#include "drivers/errors.hpp"

namespace shaker::run {

namespace {
constexpr double transient_periods = 1;  // settling time of the suspension after a ramp
constexpr int between_levels = 5;        // periods of the ramps between levels of the identification
}  // namespace

Sequence::Sequence(const RunPlan& plan, double dac_rate_hz, const AccelerometerInfo& accelerometer, Say say)
    : plan_{plan},
      dac_rate_hz_{dac_rate_hz},
      frequency_{Synthesiser::realised(plan.controller.drive.frequency, dac_rate_hz)},
      say_{std::move(say)},
      windows_{dac_rate_hz, accelerometer, plan.controller.drive.frequency, control::controlled_harmonics,
               plan.line_hz},
      controller_{plan.controller},
      walker_{frequency_},
      guard_{plan.limits, accelerometer, dac_rate_hz, plan.gravity},
      drive_{dac_rate_hz},
      notes_{plan.notes} {}

bool Sequence::step(const acquisition::Streams& streams, acquisition::Channels& channels) {
    const std::size_t before = plays_ + blocks_ + changes_ + stops_.size() + walker_.seen();
    take_trips(streams, channels);
    take_stamps(streams, channels);
    take_accelerations(streams, channels);
    watch(streams, channels);
    clocks_known_ = streams.timebase.ready();
    check_walker(channels);
    note_failures(streams.cameras);
    std::visit([&](auto& now) { advance(now, channels); }, state_);
    return plays_ + blocks_ + changes_ + stops_.size() + walker_.seen() != before;
}

// The first trip is the cause; the output has already begun its ramp to zero.
void Sequence::take_trips(const acquisition::Streams& streams, acquisition::Channels& channels) {
    while (stops_.size() < streams.trips.size()) {
        const safety::Trip& trip = streams.trips[stops_.size()];
        stops_.push_back({state(), measuring()});
        note(fmt::format("stopped in state {}: {}", name(state()), text(trip)));
        if (trip.cause == safety::Cause::transverse && controller_.hums())
            note("mains: the hum counts as motion across the axis; remove it first");
        const auto* check = std::get_if<LoopCheck>(&state_);
        if (check != nullptr && !check->over && trip.cause == safety::Cause::sensor_open)
            note("loop check: noise: the sensor shows no motion; its lead or the amplifier may be off");
        newest_trip_ = trip.number;
        auto* before = std::get_if<Tripped>(&state_);
        if (before != nullptr && before->phase != Tripped::Phase::clearing) continue;
        trip_ = trip;
        if (trip.cause == safety::Cause::walker_edge && !edge_trip_mm_) edge_trip_mm_ = trip.value;
        cause_ = stops_.size() - 1;
        const Tripped tripped{.at_s = now_s_};
        if (before != nullptr)
            *before = tripped;
        else
            go(tripped, channels);
    }
}

void Sequence::watch(const acquisition::Streams& streams, acquisition::Channels& channels) {
    const std::string followed = walker_.camera();
    walker_.add(streams, now_s_, plan_.limits.camera_missing_s);
    if (!driving(state())) return;
    if (const auto far = base_.watch(streams, frequency_, plan_.limits.displacement.abort))
        take(*far, channels);
    guard_.check_view(walker_, now_s_, channels);
    if (followed.empty() || followed == walker_.camera() || std::exchange(order_.view_noted, true)) return;
    note(fmt::format(
        "camera \"{}\" sends no pictures of the walker; camera \"{}\" is followed from {:.3f} s on", followed,
        walker_.camera(), now_s_));
}

void Sequence::take(const BaseFinding& finding, acquisition::Channels& channels) {
    const bool first = !guard_.ordered();
    if (!finding.trip || (guard_.stop(*finding.trip, now_s_, channels) && first)) note(finding.note);
}

void Sequence::check_walker(acquisition::Channels& channels) {
    const RunState now = state();
    const auto place = walker_.mean_edge_mm();
    if (place && *place >= plan_.limits.edge_mm) edge_trip_mm_.reset();
    if (!driving(now) || now == RunState::ramp_down) return;
    if (!permit_ || permit_->over()) return guard_.check(walker_, now_s_, channels);
    const auto* run = std::get_if<Run>(&state_);
    const double periods = run != nullptr ? (now_s_ - run->from_s) * frequency_ : 0;
    std::optional<safety::EdgePermit::Place> seen;
    if (place) seen = {*walker_.edge_mm(), *place};
    if (const auto trip = permit_->judge(seen, walker_.lost(), periods)) guard_.stop(*trip, now_s_, channels);
    if (permit_->over()) note("the walker is inside the edge limit again");
}

void Sequence::note_failures(const std::vector<acquisition::CameraStream>& cameras) {
    cameras_failed_.resize(cameras.size());
    for (std::size_t i = 0; i < cameras.size(); ++i)
        if (!cameras[i].failure.empty() && !cameras_failed_[i]) {
            cameras_failed_[i] = true;
            note(fmt::format("camera \"{}\" has failed: {}", cameras[i].view.camera, cameras[i].failure));
        }
}

void Sequence::take_stamps(const acquisition::Streams& streams, acquisition::Channels& channels) {
    for (; plays_ < streams.dropped.played + streams.played.size(); ++plays_) {
        const PlayTime& played = streams.played[plays_ - streams.dropped.played];
        const double heard_s = seconds(streams.timebase.at(played.tick));
        if (played.lost > 0) {
            ++underruns_;
            start_again(played.lost, channels);
            now_s_ = std::max(now_s_, heard_s);  // the clock starts again and may be behind
            walker_.dac_was_silent(duration_s(played.lost, dac_rate_hz_), now_s_);
        } else {
            now_s_ = heard_s;
        }
    }
    for (; changes_ < streams.dropped.changes + streams.changes.size(); ++changes_) {
        const DriveChange& c = streams.changes[changes_ - streams.dropped.changes];
        windows_.add(c);
        drive_.add(c, transient_periods / frequency_);
    }
}

// The DAC ran empty and stands at zero: the present measurement is abandoned. The drive restarts softly
// unless there was a trip, or too many restarts.
void Sequence::start_again(std::int64_t lost, acquisition::Channels& channels) {
    guard_.clocks_lost();
    if (done()) return;
    note(fmt::format("the DAC ran empty at {:.3f} s and was silent for {:.1f} ms", now_s_,
                     1e3 * duration_s(lost, dac_rate_hz_)));
    if (state() == RunState::ramp_down) return go(Idle{.ended = !plan_.on_call}, channels);  // silent already
    if (!driving(state())) return;
    if (++order_.restarts > plan_.most_restarts) {
        note(fmt::format("the DAC ran empty {} times; the drive restarts at most {} times", order_.restarts,
                         plan_.most_restarts));
        return stop(channels, {.cause = safety::Cause::underrun, .value = static_cast<double>(lost)});
    }
    if (state() == RunState::identify) return go_for_target(plan_.soft_start, channels);
    const auto* check = std::get_if<LoopCheck>(&state_);
    check_loop(check == nullptr || check->resumes, channels);
}

void Sequence::take_accelerations(const acquisition::Streams& streams, acquisition::Channels& channels) {
    for (; blocks_ < streams.dropped.blocks + streams.blocks.size(); ++blocks_) {
        const AccelBlock& block = streams.blocks[blocks_ - streams.dropped.blocks];
        last_tick_ = {block.first.n + block.size - 1};
        for (const control::PeriodWindows::Window& window : windows_.add(block, streams.timebase)) {
            newest_ = window;
            window_done(window, streams, channels);
        }
    }
}

// The only feedback path: the harmonics measured in a window correct the drive.
void Sequence::window_done(const control::PeriodWindows::Window& window, const acquisition::Streams& streams,
                           acquisition::Channels& channels) {
    const RunState now = state();
    if (auto* quiet = std::get_if<Quiet>(&state_); quiet != nullptr && window.from_s >= quiet->from_s) {
        controller_.quiet(window.estimate);
        quiet->judged = guard_.check_at_rest(window, channels);
    }
    if (auto* check = std::get_if<LoopCheck>(&state_)) return take_check(*check, window, channels);
    if (now != RunState::identify && now != RunState::run) return;
    // False while a newer command is still on its way to the output.
    const bool newest = window.sequence >= drive_.newest();
    const control::DriveController::Outcome outcome = controller_.take(window, newest);
    // A window from before the last change of target belongs to the previous target and frequency.
    const bool current = now == RunState::identify || window.from_s >= drive_.target_from_s();
    const bool followed = current && now == RunState::run && plan_.controller.equalise;
    guard_.check(window, controller_, {current, followed}, streams.timebase, last_tick_, channels);
    if (window.motion.steady)
        for (const BaseFinding& finding :
             base_.judge(streams, window, windows_.history(), now == RunState::run))
            take(finding, channels);
    switch (outcome) {
        case control::DriveController::Outcome::nothing:
            break;
        case control::DriveController::Outcome::step:
            if (const control::IdentifiedResponse* found = controller_.found())
                guard_.check(*found, false, now_s_, channels);
            command(controller_.volts(), now == RunState::identify ? between_levels : 1, true, channels);
            break;
        case control::DriveController::Outcome::correction:
            command(controller_.volts(), 1, false, channels);
            break;
        case control::DriveController::Outcome::identified:
            identified(channels);
            break;
    }
    if (state() == RunState::run) report(window);
}

void Sequence::identified(acquisition::Channels& channels) {
    for (const std::string& finding : findings(*controller_.identified())) note(finding);
    guard_.check(*controller_.identified(), true, now_s_, channels);
    if (order_.only_identify)
        come_down(channels);
    else
        start(channels);
}

void Sequence::report(const control::PeriodWindows::Window& window) {
    if (plan_.on_call) return;  // clients read the published state
    // Once a second when the drive is locked, else four times a second.
    const bool locked = controller_.report().locked;
    if (window.from_s < reported_s_ + (locked ? 1 : 0.25)) return;
    reported_s_ = window.from_s;
    const Drive got = drive_of(window.estimate.along, frequency_);
    say_(fmt::format("{:7.3f} s  gamma {:.4f} m/s^2  phi {:+.3f} deg  drive {}", window.from_s, got.gamma,
                     got.phi * 180 / std::numbers::pi,
                     !plan_.controller.equalise ? "open loop" : (locked ? "locked" : "settling")));
}

void Sequence::arm(acquisition::Channels& channels) {
    go(Armed{}, channels);
    note_mains();
    base_.begin();
    if (!walker_.has_target() && !std::exchange(no_target_noted_, true))
        note("no camera has a target \"walker\": nothing stops the drive when the walker leaves the base");
    const bool identifies = plan_.task.identifies || order_.only_identify;
    if (identifies && !controller_.identified() && controller_.begin_identification()) {
        go(Identify{}, channels);
        say_("identification: measuring the response of the base to the drive");
        command(controller_.volts(), plan_.soft_start, true, channels);
    } else {
        check_loop(false, channels);
    }
}

void Sequence::start(acquisition::Channels& channels) {
    controller_.begin();
    note_mains();
    go(Ramp{}, channels);
    say_(fmt::format("soft start over {} periods", plan_.soft_start));
    go_for_target(plan_.soft_start, channels);
}

// Starts towards the controller's target. No window is compared with the target until the command is in
// force.
void Sequence::go_for_target(int ramp_periods, acquisition::Channels& channels) {
    command(controller_.volts(), ramp_periods, true, channels);
    guard_.settling();
    drive_.aim();
    if (auto* run = std::get_if<Run>(&state_)) run->kept_from_s = -INFINITY;
}

void Sequence::note(const std::string& what) {
    say_(what);
    notes_.push_back(what);
}

void Sequence::command(const Harmonics<Voltage>& volts, int ramp_periods, bool transient,
                       acquisition::Channels& channels) {
    channels.drive.post({.volts = volts,
                         .frequency = controller_.drive().frequency,
                         .ramp_periods = ramp_periods,
                         .sequence = drive_.next(),
                         .underruns = underruns_});
    if (transient) drive_.await();
}

}  // namespace shaker::run
