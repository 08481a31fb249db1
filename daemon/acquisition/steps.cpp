#include "daemon/acquisition/steps.hpp"

#include <spdlog/spdlog.h>

#include <array>
#include <span>
#include <utility>

#include "drivers/errors.hpp"

namespace shaker::acquisition {

namespace {

constexpr std::uint64_t frames_per_search = 50;

std::span<const tracking::Fix> update(tracking::ViewTracker& tracker, const Frame& frame) {
    return frame.sightings.empty() ? tracker.update(frame.view(), frame.tick)
                                   : tracker.update(frame.sightings);
}

// This thread may wait for the log.
void tell_corrections(const tracking::ViewTracker& tracker) {
    for (const std::string& correction : tracker.corrections()) spdlog::warn("{}", correction);
}

std::span<const tracking::Fix> first_found_in(const Frame& frame, CameraInput& input) {
    const auto fixes = update(input.tracker, frame);
    tell_corrections(input.tracker);
    input.begun = true;
    return fixes;
}

// Learning takes many times longer than following.
std::span<const tracking::Fix> searched_in(const Frame& frame, CameraInput& input) {
    if (input.unfound++ % frames_per_search != 0) return {};
    try {
        return first_found_in(frame, input);
    } catch (const InputError& e) {
        input.not_found = e.what();
        return {};
    }
}

std::span<const tracking::Fix> found_in(const Frame& frame, CameraInput& input, Counters& lost) {
    if (const auto fresh = input.fresh.pop()) {
        ++input.learned;
        try {
            const auto fixes = update(**fresh, frame);
            tell_corrections(**fresh);
            input.tracker = std::move(**fresh);
            input.begun = true;
            return fixes;
        } catch (const InputError&) {
            ++lost.not_learned;
        }
    }
    if (input.begun) return update(input.tracker, frame);
    return input.patient ? searched_in(frame, input) : first_found_in(frame, input);
}

}  // namespace

bool accelerometer_step(AccelerometerInput& input, Accelerometer& device, std::chrono::milliseconds wait,
                        Channels& channels) {
    AccelBlock block;
    const bool came = device.read(block, wait);
    std::array<std::array<std::int32_t, 3>, AccelBlock::capacity> early;
    while (const std::size_t n = device.read_early(early)) {
        input.guard.check_early(std::span{early}.first(n), channels.sensed, channels.warnings);
        channels.heard += n;
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
    channels.checked_to = block.first.n + block.size;
    channels.checked_arrived = block.arrived;
    ++channels.judged;
    if (!channels.blocks.push(block)) ++channels.lost.blocks_lost;
    return true;
}

bool camera_step(Camera& device, CameraInput& camera_input, std::chrono::milliseconds wait,
                 Ring<TrackedFrame>& out, Counters& lost, TimeHistogram& tracking) {
    FramePtr frame = device.read(wait);
    if (frame == nullptr) return false;
    // A lost frame is not tracked either, so that a replay, which does not have it, gives the same tracks.
    if (out.full()) {
        ++lost.frames_lost;
        return true;
    }
    const auto before = std::chrono::steady_clock::now();
    const bool follows = camera_input.begun;  // the first picture teaches the tracker, which takes longer
    const auto fixes = found_in(*frame, camera_input, lost);
    if (follows && frame->sightings.empty())
        tracking.add(std::chrono::duration<double>{std::chrono::steady_clock::now() - before}.count());
    static_cast<void>(out.push({std::move(frame),
                                {fixes.begin(), fixes.end()},
                                camera_input.learned,
                                camera_input.begun ? std::string{} : camera_input.not_found}));
    return true;
}

void abort_input_step(AbortInput& device, std::chrono::milliseconds wait, Channels& channels) {
    const Contact contact = device.read(wait);
    if (channels.contact.exchange(contact) == Contact::closed && contact != Contact::closed)
        ++channels.openings;
    ++channels.contact_reads;
}

}  // namespace shaker::acquisition
