#include "daemon/loops.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "drivers/errors.hpp"

namespace shaker {

namespace {

double drive_limit(const DacInfo& dac, const std::optional<Limits>& limits) {
    return limits ? std::min(limits->drive.abort, dac.full_scale_V) : dac.full_scale_V;
}

// To the reduction and, ahead of the sound, to the guard of the accelerometer.
void tell(const Output& output, Lanes& lanes) {
    const DriveChange* change = output.synthesiser.change();
    if (change == nullptr) return;
    if (!lanes.changes.push(*change)) ++lanes.lost.changes_lost;
    if (output.guard.armed() && !lanes.ahead.push(*change)) ++lanes.lost.changes_lost;
}

void stop(const Trip& trip, Output& output, Lanes& lanes) {
    if (!lanes.trips.push(trip)) ++lanes.lost.trips_lost;
    output.synthesiser.stop(output.guard.stop_samples(trip.stop));
    tell(output, lanes);
}

double peak(const std::vector<double>& volts) noexcept {
    double largest = 0;
    for (const double v : volts) largest = std::max(largest, std::abs(v));
    return largest;
}

// What happened in the block before, and what the other threads have done meanwhile.
OutputSigns signs_of(const Output& output, const Lanes& lanes) {
    const Synthesiser& s = output.synthesiser;
    return {.tick = s.tick().n,
            .silent = s.silent(),
            .peak_V = peak(output.volts),
            .clamped = s.clamped(),
            .largest_clamped_V = s.largest_clamped(),
            .lost = output.lost,
            .signs_of_life = lanes.signs_of_life,
            .gathered = lanes.gathered};
}

void answer_trips(Output& output, Lanes& lanes) {
    const std::uint64_t releases = lanes.releases;
    if (releases != output.released && output.synthesiser.release()) {
        output.released = releases;
        output.guard.rearm();
    }
    if (const std::uint64_t aborts = lanes.aborts; aborts != output.aborted) {
        output.aborted = aborts;
        const bool over = output.synthesiser.stopped() && output.synthesiser.silent();
        if (!over)
            stop({.cause = Cause::operator_stop,
                  .stop = StopKind::hard,
                  .on_dac_clock = true,
                  .tick = output.synthesiser.tick().n},
                 output, lanes);
        lanes.aborts_answered = aborts;
    }
    // Its own findings first: where the DAC ran empty, that is why the base was not where it should have
    // been.
    if (const auto trip = output.guard.check(signs_of(output, lanes), lanes.warnings))
        stop(*trip, output, lanes);
    while (const auto trip = lanes.sensed.pop()) stop(*trip, output, lanes);
    while (const auto trip = lanes.ordered.pop()) stop(*trip, output, lanes);
}

std::span<const Fix> found_in(const Frame& frame, Eye& eye, Counters& lost) {
    if (const auto fresh = eye.fresh.pop()) {
        ++eye.learned;
        try {
            const auto fixes = (*fresh)->update(frame.view(), frame.tick);
            eye.tracker = std::move(**fresh);
            return fixes;
        } catch (const InputError&) {
            ++lost.not_learned;
        }
    }
    return eye.tracker.update(frame.view(), frame.tick);
}

}  // namespace

Output::Output(const DacInfo& dac, double frequency, double frames_per_second, std::size_t block,
               const std::optional<Limits>& limits, double accelerometer_rate_hz)
    : synthesiser{dac.rate_hz, frequency, drive_limit(dac, limits)},
      guard{dac.rate_hz, accelerometer_rate_hz, limits},
      triggers{dac.rate_hz, frames_per_second},
      volts(block),
      pulses(block) {}

void output_step(Output& output, Dac& dac, Lanes& lanes) {
    Synthesiser& synthesiser = output.synthesiser;
    if (const auto limits = lanes.output_limits.take()) output.guard.hold_to(*limits);
    answer_trips(output, lanes);
    if (const auto command = lanes.drive.take()) synthesiser.set(*command);
    synthesiser.fill(output.volts);
    output.triggers.fill(output.pulses);
    tell(output, lanes);
    const PlayTime played = dac.write(output.volts, output.pulses);
    if (!lanes.played.push(played)) ++lanes.lost.plays_lost;
    if (played.lost > 0) {  // never go on at level: what comes next starts from silence
        synthesiser.silence(played.lost);
        output.triggers.skip(played.lost);
        tell(output, lanes);
    }
    output.lost = played.lost;
    lanes.stopped = synthesiser.stopped();
    lanes.lost.samples_clamped = synthesiser.clamped();
}

bool accelerometer_step(Input& input, Accelerometer& device, std::chrono::milliseconds wait, Lanes& lanes) {
    AccelBlock block;
    const bool came = device.read(block, wait);
    if (const std::uint64_t heard = device.heard(); came || heard != input.heard) {
        input.heard = heard;
        ++lanes.signs_of_life;
    }
    if (!came) return false;
    if (const std::uint64_t releases = lanes.releases; releases != input.released) {
        input.released = releases;
        input.guard.rearm();
    }
    if (const auto limits = lanes.input_limits.take()) input.guard.hold_to(*limits);
    while (const auto change = lanes.ahead.pop()) input.guard.hear(*change);
    if (const auto expectation = lanes.expectation.take()) input.guard.expect(*expectation);
    input.guard.check(block, lanes.sensed, lanes.warnings);
    if (!lanes.blocks.push(block)) ++lanes.lost.blocks_lost;
    return true;
}

bool camera_step(Camera& device, Eye& eye, std::chrono::milliseconds wait, Ring<TrackedFrame>& out,
                 Counters& lost) {
    FramePtr frame = device.read(wait);
    if (frame == nullptr) return false;
    // A frame that cannot be handed on is not tracked either: a replay, which does not have it, then sees
    // what this saw.
    if (out.full()) {
        ++lost.frames_lost;
        return true;
    }
    const auto fixes = found_in(*frame, eye, lost);
    static_cast<void>(out.push({std::move(frame), {fixes.begin(), fixes.end()}, eye.learned}));
    return true;
}

}  // namespace shaker
