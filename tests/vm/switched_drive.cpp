#include "tests/vm/switched_drive.hpp"

#include <thread>

#include "daemon/acquisition/drive_output.hpp"
#include "daemon/acquisition/steps.hpp"
#include "drivers/realtime.hpp"

namespace shaker {

namespace {

HostTime heard_at(DacTick tick, const PlayTime& seen, double rate_hz) {
    return seen.heard +
           std::chrono::nanoseconds{std::llround(1e9 * static_cast<double>(tick.n - seen.tick.n) / rate_hz)};
}

}  // namespace

SwitchedDrive drive_switched(Rig& rig, double seconds) {
    constexpr double frequency = 50, volts = 0.3, stop_s = 0.2, played_out_s = 0.3;
    const DacInfo info = rig.dac->info();
    acquisition::Channels channels{0};
    acquisition::DriveOutput output{info, frequency, 0, info.block_frames};
    output.has_contact = true;
    const std::jthread contact{[&](const std::stop_token& stop) {
        static_cast<void>(use_fifo_priority(fifo_priority::abort_input));
        while (!stop.stop_requested())
            acquisition::abort_input_step(*rig.abort_input, std::chrono::milliseconds{50}, channels);
    }};
    SwitchedDrive done;
    PlayTime seen;
    std::optional<DacTick> ramp;
    DriveCommand command{.volts = {}, .frequency = frequency};
    command.volts.at(1) = volts;
    const auto go = [&](double s, bool until_trip) {
        const std::int64_t end = output.synthesiser.tick().n + std::llround(s * info.rate_hz);
        while (output.synthesiser.tick().n < end && !(until_trip && done.trip)) {
            output_step(output, *rig.dac, channels);
            while (const auto c = channels.changes.pop()) {
                if (!ramp && c->stop > 0) ramp = c->first;
            }
            while (const auto p = channels.played.pop()) {
                seen = *p;
                if (p->lost == 0 || !until_trip) continue;
                command.underruns = output.underruns;
                channels.drive.post(command);  // an emulated machine is slow
            }
            while (const auto t = channels.trips.pop())
                if (!done.trip) done.trip = *t;
        }
    };
    while (channels.contact_reads < 3) std::this_thread::sleep_for(std::chrono::milliseconds{1});
    channels.drive.post(command);
    go(seconds, true);
    if (!done.trip) channels.drive.post({.volts = {}, .stop_s = stop_s});
    go(stop_s + played_out_s, false);
    if (ramp) done.ramp = heard_at(*ramp, seen, info.rate_hz);
    return done;
}

}  // namespace shaker
