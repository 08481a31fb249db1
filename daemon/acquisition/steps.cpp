#include "daemon/acquisition/steps.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "drivers/errors.hpp"

namespace shaker::acquisition {

namespace {

double drive_limit(const DacInfo& dac, const std::optional<safety::Limits>& limits) {
    return limits ? std::min(limits->drive.abort, dac.full_scale_V) : dac.full_scale_V;
}

// Passes a change of the drive to the reduction and, before it is audible, to the accelerometer's guard.
void push_change(const DriveOutput& output, Channels& channels) {
    const DriveChange* change = output.synthesiser.change();
    if (change == nullptr) return;
    if (!channels.changes.push(*change)) ++channels.lost.changes_lost;
    if (output.guard.armed() && !channels.ahead.push(*change)) ++channels.lost.changes_lost;
}

void stop(const safety::Trip& trip, DriveOutput& output, Channels& channels) {
    if (!channels.trips.push(trip)) ++channels.lost.trips_lost;
    output.synthesiser.stop(output.guard.stop_samples(trip.stop));
    push_change(output, channels);
}

double peak(const std::vector<double>& volts) noexcept {
    double largest = 0;
    for (const double v : volts) largest = std::max(largest, std::abs(v));
    return largest;
}

// State of the output after the last block, and signs of life of the other threads.
safety::OutputSigns signs_of(const DriveOutput& output, const Channels& channels) {
    const Synthesiser& s = output.synthesiser;
    return {.tick = s.tick().n,
            .silent = s.silent(),
            .peak_V = peak(output.volts),
            .clamped = s.clamped(),
            .largest_clamped_V = s.largest_clamped(),
            .lost = output.lost,
            .signs_of_life = channels.signs_of_life,
            .gathered = channels.gathered};
}

void answer_trips(DriveOutput& output, Channels& channels) {
    const std::uint64_t releases = channels.releases;
    if (releases != output.released && output.synthesiser.release()) {
        output.released = releases;
        output.guard.rearm();
    }
    if (const std::uint64_t aborts = channels.aborts; aborts != output.aborted) {
        output.aborted = aborts;
        const bool over = output.synthesiser.stopped() && output.synthesiser.silent();
        if (!over)
            stop({.cause = safety::Cause::operator_stop,
                  .stop = safety::StopKind::hard,
                  .on_dac_clock = true,
                  .tick = output.synthesiser.tick().n},
                 output, channels);
        channels.aborts_answered = aborts;
    }
    // The output's own trips first: an empty DAC also makes the base miss its predicted motion.
    if (const auto trip = output.guard.check(signs_of(output, channels), channels.warnings))
        stop(*trip, output, channels);
    while (const auto trip = channels.sensed.pop()) stop(*trip, output, channels);
    while (const auto trip = channels.ordered.pop()) stop(*trip, output, channels);
}

std::span<const tracking::Fix> found_in(const Frame& frame, CameraInput& camera_input, Counters& lost) {
    if (const auto fresh = camera_input.fresh.pop()) {
        ++camera_input.learned;
        try {
            const auto fixes = (*fresh)->update(frame.view(), frame.tick);
            camera_input.tracker = std::move(**fresh);
            return fixes;
        } catch (const InputError&) {
            ++lost.not_learned;
        }
    }
    return camera_input.tracker.update(frame.view(), frame.tick);
}

}  // namespace

DriveOutput::DriveOutput(const DacInfo& dac, double frequency, double frames_per_second, std::size_t block,
                         const std::optional<safety::Limits>& limits, double accelerometer_rate_hz)
    : synthesiser{dac.rate_hz, frequency, drive_limit(dac, limits)},
      guard{dac.rate_hz, accelerometer_rate_hz, limits},
      triggers{dac.rate_hz, frames_per_second},
      volts(block),
      pulses(block) {}

void output_step(DriveOutput& output, Dac& dac, Channels& channels) {
    Synthesiser& synthesiser = output.synthesiser;
    if (const auto limits = channels.output_limits.take()) output.guard.hold_to(*limits);
    answer_trips(output, channels);
    if (const auto command = channels.drive.take()) synthesiser.set(*command);
    synthesiser.fill(output.volts);
    output.triggers.fill(output.pulses);
    push_change(output, channels);
    const PlayTime played = dac.write(output.volts, output.pulses);
    if (!channels.played.push(played)) ++channels.lost.plays_lost;
    if (played.lost > 0) {  // the next sample starts from silence, never at full level
        synthesiser.silence(played.lost);
        output.triggers.skip(played.lost);
        push_change(output, channels);
    }
    output.lost = played.lost;
    channels.stopped = synthesiser.stopped();
    channels.lost.samples_clamped = synthesiser.clamped();
}

bool accelerometer_step(AccelerometerInput& input, Accelerometer& device, std::chrono::milliseconds wait,
                        Channels& channels) {
    AccelBlock block;
    const bool came = device.read(block, wait);
    if (const std::uint64_t heard = device.heard(); came || heard != input.heard) {
        input.heard = heard;
        ++channels.signs_of_life;
    }
    if (!came) return false;
    if (const std::uint64_t releases = channels.releases; releases != input.released) {
        input.released = releases;
        input.guard.rearm();
    }
    if (const auto limits = channels.input_limits.take()) input.guard.hold_to(*limits);
    while (const auto change = channels.ahead.pop()) input.guard.hear(*change);
    if (const auto expectation = channels.expectation.take()) input.guard.expect(*expectation);
    input.guard.check(block, channels.sensed, channels.warnings);
    if (!channels.blocks.push(block)) ++channels.lost.blocks_lost;
    return true;
}

bool camera_step(Camera& device, CameraInput& camera_input, std::chrono::milliseconds wait,
                 Ring<TrackedFrame>& out, Counters& lost) {
    FramePtr frame = device.read(wait);
    if (frame == nullptr) return false;
    // A lost frame is not tracked either, so that a replay, which does not have it, gives the same tracks.
    if (out.full()) {
        ++lost.frames_lost;
        return true;
    }
    const auto fixes = found_in(*frame, camera_input, lost);
    static_cast<void>(out.push({std::move(frame), {fixes.begin(), fixes.end()}, camera_input.learned}));
    return true;
}

}  // namespace shaker::acquisition
