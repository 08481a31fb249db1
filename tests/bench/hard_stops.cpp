// Time from an abort to silence on the mock sound card, with and without taking back its queue.
//   --count N (200) aborts a row, at random phases   --seed N (1)
#include "tests/support/devices/hard_stops.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "drivers/hardware/alsa/alsa_dac.hpp"
#include "drivers/hardware/alsa/pcm_codec.hpp"
#include "tests/bench/option.hpp"
#include "tests/bench/table.hpp"
#include "tests/support/devices/mock_dac.hpp"

namespace {

using namespace shaker;

/// As a card that cannot take frames back, with the same ramp behind the drive.
class Leaves final : public Dac {
public:
    explicit Leaves(Dac& inner) : inner_{inner} {}
    [[nodiscard]] DacInfo info() const override {
        DacInfo i = inner_.info();
        i.kept_frames = i.queue_frames;
        return i;
    }
    [[nodiscard]] DeviceCounts counts() const noexcept override { return inner_.counts(); }
    PlayTime write(std::span<const double> volts, std::span<const double> trigger) override {
        return inner_.write(volts, trigger);
    }
    void stop() noexcept override { inner_.stop(); }

private:
    Dac& inner_;
};

struct Card {
    std::string name;
    int period, buffer;
};

double quantile(std::vector<double> values, double q) {
    std::ranges::sort(values);
    return values.empty()
               ? NAN
               : values[static_cast<std::size_t>(q * static_cast<double>(values.size() - 1) + 0.5)];
}

/// Samples that were heard otherwise than recorded.
std::int64_t wrong(const test::MockDac& mock, const alsa::AlsaSettings& s, const std::vector<double>& volts) {
    const auto start = static_cast<std::size_t>(mock.converter.stream_starts().at(0)) +
                       static_cast<std::size_t>(s.buffer_frames - s.ramp_frames());
    const alsa::PcmCodec codec{s.format, 0, s.full_scale_V};
    std::int64_t n = 0;
    for (std::size_t i = 0; i < volts.size(); ++i)
        n += mock.first.at(start + i) != std::int64_t{codec.code(volts[i])} << (32 - codec.bits()) ? 1 : 0;
    return n;
}

void add_row(bench::Table& table, const Card& card, bool takes_back, int count, unsigned seed) {
    test::MockDac mock;
    alsa::AlsaSettings s = mock.settings;
    s.period_frames = card.period;
    s.buffer_frames = card.buffer;
    s.dither = false;
    test::HardStops all;
    DacInfo info;
    {
        alsa::AlsaDac dac{s};
        info = dac.info();
        const std::jthread listener{[&](const std::stop_token& stop) {
            while (!stop.stop_requested()) mock.listen_for(Seconds{0.1});
        }};
        Leaves leaves{dac};
        all = takes_back ? test::stop_hard(dac, count, seed) : test::stop_hard(leaves, count, seed);
    }
    mock.listen();
    std::vector<double> silent_ms;
    double taken = 0;
    for (const test::HardStop& stop : all.stops) {
        silent_ms.push_back(1e3 * stop.silent_s);
        taken +=
            1e3 * static_cast<double>(stop.taken_back) / s.rate_hz / static_cast<double>(all.stops.size());
    }
    table.add(
        {{"card", card.name},
         {"period", 1e3 * card.period / s.rate_hz, "ms", 3},
         {"queue", 1e3 * static_cast<double>(info.queue_frames) / s.rate_hz, "ms", 3},
         {"stays", 1e3 * static_cast<double>(takes_back ? info.kept_frames : info.queue_frames) / s.rate_hz,
          "ms", 3},
         {"ramp", 5., "ms", 3},
         {"aborts", static_cast<double>(all.stops.size()), "", 6},
         {"taken back", taken, "ms", 3},
         {"silent p50", quantile(silent_ms, 0.5), "ms", 3},
         {"p99", quantile(silent_ms, 0.99), "ms", 3},
         {"worst", quantile(silent_ms, 1), "ms", 3},
         {"largest step", all.largest_step, "V", 3},
         {"drive's and ramp's own", all.own_step, "V", 3},
         {"samples", static_cast<double>(all.volts.size()), "", 9},
         {"not as recorded",
          all.counts.incidents == 0 ? static_cast<double>(wrong(mock, s, all.volts)) : NAN},
         {"underruns", static_cast<double>(all.counts.incidents)},
         {"conditions",
          "mock converter in real time, 48 kHz, two harmonics of 0.4 V at 50 to 150 Hz, "
          "blocks of 5 ms; time from the abort to the first silent sample"}});
}

}  // namespace

int main(int argc, char** argv) {
    const int count = bench::whole_option(argc, argv, "--count", 200, 1);
    const int seed = bench::whole_option(argc, argv, "--seed", 1, 0);
    const alsa::AlsaSettings defaults;
    bench::Table table;
    for (const Card& card : {Card{"example of WIRING.md", 240, 3360},
                             Card{"defaults", defaults.period_frames, defaults.buffer_frames},
                             Card{"short periods", 96, 3360}, Card{"long queue", 240, 4800}})
        for (const bool takes_back : {true, false})
            add_row(table, card, takes_back, count, static_cast<unsigned>(seed));
    table.print(argc, argv);
}
