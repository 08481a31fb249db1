#include "daemon/loops.hpp"

namespace shaker {

Output::Output(const DacInfo& dac, double frequency, double frames_per_second, std::size_t block)
    : synthesiser{dac.rate_hz, frequency, dac.full_scale_V},
      triggers{dac.rate_hz, frames_per_second},
      volts(block),
      pulses(block) {}

void output_step(Output& output, Dac& dac, Lanes& lanes) {
    if (const auto command = lanes.drive.take()) output.synthesiser.set(*command);
    output.synthesiser.fill(output.volts);
    output.triggers.fill(output.pulses);
    const DriveChange* change = output.synthesiser.change();
    if (change != nullptr && !lanes.changes.push(*change)) ++lanes.lost.changes_lost;
    const PlayTime played = dac.write(output.volts, output.pulses);
    if (!lanes.played.push(played)) ++lanes.lost.plays_lost;
    if (played.lost > 0) {  // never go on at level: what comes next starts from silence
        output.synthesiser.silence(played.lost);
        output.triggers.skip(played.lost);
        if (!lanes.changes.push(*output.synthesiser.change())) ++lanes.lost.changes_lost;
    }
    lanes.lost.samples_clamped = output.synthesiser.clamped();
}

bool accelerometer_step(Accelerometer& device, std::chrono::milliseconds wait, Lanes& lanes) {
    AccelBlock block;
    if (!device.read(block, wait)) return false;
    if (!lanes.blocks.push(block)) ++lanes.lost.blocks_lost;
    return true;
}

bool camera_step(Camera& device, ViewTracker& tracker, std::chrono::milliseconds wait,
                 Ring<TrackedFrame>& out, Counters& lost) {
    FramePtr frame = device.read(wait);
    if (frame == nullptr) return false;
    // A frame that cannot be handed on is not tracked either: a replay, which does not have it, then sees
    // what this saw.
    if (out.full()) {
        ++lost.frames_lost;
        return true;
    }
    const auto fixes = tracker.update(frame->view(), frame->tick);
    static_cast<void>(out.push({std::move(frame), {fixes.begin(), fixes.end()}}));
    return true;
}

}  // namespace shaker
