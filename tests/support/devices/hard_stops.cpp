#include "tests/support/devices/hard_stops.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <numbers>
#include <random>
#include <thread>

#include "daemon/acquisition/drive_output.hpp"
#include "drivers/recorded/played_drive.hpp"
#include "tests/mock/converter.hpp"
#include "tests/support/stall_probe.hpp"

namespace shaker::test {

namespace {

constexpr double amplitude_V = 0.4;  // of each harmonic
constexpr double lowest_hz = 50, highest_hz = 150;
constexpr double lead_s = 0.03;  // from the start of a drive until the operator may abort

/// Aborts once after each wish, at a random time within 20 ms.
class Operator {
public:
    Operator(acquisition::Channels& channels, unsigned seed)
        : thread_{[this, &channels, seed](const std::stop_token& stop) {
              std::mt19937 random{seed};
              for (std::uint64_t answered = 0; !stop.stop_requested();) {
                  if (wishes_ == answered) {
                      std::this_thread::sleep_for(std::chrono::milliseconds{1});
                      continue;
                  }
                  ++answered;
                  std::this_thread::sleep_for(std::chrono::microseconds{random() % 20000});
                  at_ = mock::host_now().time_since_epoch().count();
                  ++channels.aborts;
              }
          }} {}
    void wish() { ++wishes_; }
    [[nodiscard]] HostTime at() const { return HostTime{std::chrono::nanoseconds{at_.load()}}; }

private:
    std::atomic<std::uint64_t> wishes_{0};
    std::atomic<std::int64_t> at_{0};
    std::jthread thread_;
};

struct Output {
    explicit Output(Dac& d) : dac{d}, info{d.info()}, output{info, lowest_hz, 0, info.block_frames} {}
    void step() {
        output_step(output, dac, channels);
        while (const auto c = channels.changes.pop()) changes.push_back(*c);
        while (const auto p = channels.played.pop()) played.push_back(*p);
        while (channels.trips.pop()) {
        }
    }
    void go(double s) {
        for (const std::int64_t end = output.synthesiser.tick().n + std::llround(s * info.rate_hz);
             output.synthesiser.tick().n < end;)
            step();
    }
    [[nodiscard]] double queue_s() const { return static_cast<double>(info.queue_frames) / info.rate_hz; }
    Dac& dac;
    DacInfo info;
    acquisition::Channels channels{0};
    acquisition::DriveOutput output;
    std::vector<DriveChange> changes;
    std::vector<PlayTime> played;
};

HardStop stop_of(const Output& run, HostTime ordered) {
    const DriveChange& c = run.changes.back();
    const PlayTime& seen = run.played.back();
    const Seconds until{static_cast<double>(c.first.n - seen.tick.n) / run.info.rate_hz};
    const double ramp_s = Seconds{seen.heard - ordered}.count() + until.count();
    return {.first = c.first.n,
            .ramp = c.stop,
            .taken_back = c.taken_back,
            .ramp_s = ramp_s,
            .silent_s = ramp_s + static_cast<double>(c.stop) / run.info.rate_hz};
}

void judge(HardStops& all, double rate_hz) {
    for (const HardStop& stop : all.stops) {
        const auto first = static_cast<std::size_t>(stop.first);
        const std::size_t end = std::min(first + static_cast<std::size_t>(stop.ramp) + 2, all.volts.size());
        for (std::size_t i = first; i < end; ++i)
            all.largest_step = std::max(all.largest_step, std::abs(all.volts[i] - all.volts[i - 1]));
        const double drive = 2 * std::numbers::pi * (1 + 2) * amplitude_V * highest_hz / rate_hz;
        const double ramp = 2 * amplitude_V * 0.5 * std::numbers::pi / static_cast<double>(stop.ramp);
        all.own_step = std::max(all.own_step, drive + ramp);
    }
}

}  // namespace

HardStops stop_hard(Dac& dac, int count, unsigned seed) {
    HardStops all;
    Output run{dac};
    Operator person{run.channels, seed};
    const StallProbe probe;
    std::mt19937 random{seed + 1};
    for (int i = 0; i < count; ++i) {
        DriveCommand drive{
            .volts = {},
            .frequency = lowest_hz + (highest_hz - lowest_hz) * static_cast<double>(random() % 1000) / 1000,
            .underruns = run.output.underruns};
        drive.volts.at(1) = amplitude_V;
        drive.volts.at(2) = {0, amplitude_V};
        run.channels.drive.post(drive);
        run.go(run.queue_s() + lead_s);
        const auto before = StallProbe::Clock::now();
        person.wish();
        while (!run.channels.stopped) run.step();
        if (run.changes.back().stop > 0) {  // else an underrun
            all.stops.push_back(stop_of(run, person.at()));
            all.stops.back().stalled = probe.longest_s(before, StallProbe::Clock::now()) > 0;
        }
        run.go(run.queue_s() + 0.01);
        run.channels.clearance.post({run.output.newest.number, run.channels.aborts});
        run.step();
    }
    all.counts = dac.counts();
    all.volts.resize(static_cast<std::size_t>(run.output.synthesiser.tick().n));
    recorded::PlayedDrive{run.info, lowest_hz, run.changes, run.played}.fill(all.volts);
    judge(all, run.info.rate_hz);
    return all;
}

}  // namespace shaker::test
