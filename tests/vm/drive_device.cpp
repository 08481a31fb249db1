#include "tests/vm/drive_device.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <optional>
#include <vector>

#include "calibration/clocks/clock_tracker.hpp"
#include "drivers/errors.hpp"
#include "tests/vm/pattern.hpp"

namespace shaker {

namespace {

using std::chrono::steady_clock;

void note(const PlayTime& played, calibration::ClockTracker<DacClock>& clock) {
    if (played.lost > 0) clock.restart();
    clock.add(played.tick, played.heard);
}

}  // namespace

Played play_pattern(Dac& dac, int bits, std::int64_t frames, const std::function<void()>& started) {
    const DacInfo info = dac.info();
    const double volts_per_code = info.full_scale_V * std::ldexp(1.0, 1 - bits);
    const auto one_second = static_cast<std::int64_t>(info.rate_hz);
    std::array<double, 256> volts{};
    const std::array<double, 256> no_trigger{};
    constexpr auto block = static_cast<std::int64_t>(volts.size());
    calibration::ClockTracker<DacClock> clock{info.rate_hz};
    Played played;
    steady_clock::time_point began;
    bool told = false;
    try {
        for (std::int64_t first = 0; first < frames + one_second / 4; first += block) {
            for (std::int64_t i = 0; i < block; ++i) {
                const std::int64_t n = first + i;
                volts[static_cast<std::size_t>(i)] = n < frames ? volts_per_code * pattern_code(n, bits) : 0;
            }
            began = steady_clock::now();
            note(dac.write(volts, no_trigger), clock);
            played.last_write_took = steady_clock::now() - began;
            played.frames = std::min(first + block, frames);
            if (!told && first > one_second) {
                told = true;
                started();
            }
        }
    } catch (const DeviceError& error) {
        played.last_write_took = steady_clock::now() - began;
        played.fault = error.what();
    }
    played.counts = dac.counts();
    played.ppm = clock.ppm();
    played.residual = clock.residual();
    return played;
}

Heard read_counted_samples(Accelerometer& accelerometer, std::int64_t samples) {
    Heard heard;
    AccelBlock block;
    std::optional<std::int64_t> count, tick;  // of the last sample
    std::optional<HostTime> first_stamp;
    std::int64_t since_first = 0;
    try {
        const auto until = steady_clock::now() + std::chrono::seconds{60};
        while (heard.samples < samples && !accelerometer.ended() && steady_clock::now() < until) {
            if (!accelerometer.read(block, std::chrono::milliseconds{200})) continue;
            for (int i = 0; i < block.size; ++i, ++heard.samples) {
                const auto& [x, y, z] = block.counts[static_cast<std::size_t>(i)];
                const std::int64_t now = block.first.n + i;
                if (x != 3 * z || y != -5 * z || (count && z <= *count)) ++heard.wrong;
                if (count) heard.missing += std::max<std::int64_t>(z - *count - 1, 0);
                if (count && now - *tick != z - *count) ++heard.misplaced;
                count = z;
                tick = now;
            }
            if (!first_stamp) {
                first_stamp = block.arrived;
                since_first = *count;
            } else {
                heard.rate_hz =
                    static_cast<double>(*count - since_first) / Seconds{block.arrived - *first_stamp}.count();
            }
        }
    } catch (const DeviceError& error) {
        heard.fault = error.what();
    }
    heard.counts = accelerometer.counts();
    return heard;
}

Watched watch(Camera& camera, Seconds duration) {
    Watched watched;
    FramePtr first, last;
    const auto began = steady_clock::now();
    try {
        while (steady_clock::now() - began < duration && !camera.ended()) {
            FramePtr frame = camera.read(std::chrono::milliseconds{200});
            if (!frame) continue;
            ++watched.frames;
            if (!first) first = frame;
            if (!frame->stamp) ++watched.unstamped;
            if (last && (frame->tick <= last->tick || frame->stamp < last->stamp)) ++watched.backwards;
            last = std::move(frame);
        }
    } catch (const DeviceError& error) {
        watched.fault = error.what();
    }
    watched.counts = camera.counts();
    if (watched.frames < 2) return watched;
    watched.span = last->tick.n - first->tick.n + 1;
    const double elapsed_s = first->stamp ? 1e-9 * static_cast<double>(last->stamp->n - first->stamp->n)
                                          : Seconds{last->arrived - first->arrived}.count();
    watched.rate_hz = static_cast<double>(watched.span - 1) / elapsed_s;
    return watched;
}

}  // namespace shaker
