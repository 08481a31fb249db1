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
#include "drivers/hardware/alsa/output_frames.hpp"
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

/// Aborts of one row. A stream that ran empty, and aborts during which the machine stood still, count apart.
struct Tally {
    std::vector<double> silent_ms;
    double taken_ms = 0, largest_step = 0, own_step = 0, samples = 0;
    std::int64_t wrong = 0, disturbed = 0, underruns = 0, stalled = 0;
    DacInfo info;
};

void add_stream(Tally& tally, const Card& card, bool takes_back, int count, unsigned seed) {
    test::MockDac mock;
    alsa::AlsaSettings s = mock.settings;
    s.period_frames = card.period;
    s.buffer_frames = card.buffer;
    s.dither = false;
    test::HardStops all;
    {
        alsa::AlsaDac dac{s};
        tally.info = dac.info();
        const std::jthread listener{[&](const std::stop_token& stop) {
            while (!stop.stop_requested()) mock.listen_for(Seconds{0.1});
        }};
        Leaves leaves{dac};
        all = takes_back ? test::stop_hard(dac, count, seed) : test::stop_hard(leaves, count, seed);
    }
    mock.listen();
    tally.underruns += static_cast<std::int64_t>(all.counts.incidents);
    if (all.counts.incidents > 0) {
        tally.disturbed += count;
        return;
    }
    for (const test::HardStop& stop : all.stops) {
        if (stop.stalled) {
            ++tally.stalled;
            continue;
        }
        tally.silent_ms.push_back(1e3 * stop.silent_s);
        tally.taken_ms += 1e3 * static_cast<double>(stop.taken_back) / s.rate_hz;
    }
    tally.largest_step = std::max(tally.largest_step, all.largest_step);
    tally.own_step = all.own_step;
    tally.samples += static_cast<double>(all.volts.size());
    tally.wrong += wrong(mock, s, all.volts);
}

void add_row(bench::Table& table, const Card& card, bool takes_back, int count, unsigned seed) {
    constexpr int of_stream = 20;
    Tally t;
    for (int done = 0; done < count; done += of_stream)
        add_stream(t, card, takes_back, std::min(of_stream, count - done),
                   seed + static_cast<unsigned>(done));
    const double ms = 1e3 / t.info.rate_hz;
    const std::int64_t stays = takes_back ? t.info.kept_frames : t.info.queue_frames;
    table.add({{"card", card.name},
               {"period", ms * card.period, "ms", 3},
               {"queue", ms * static_cast<double>(t.info.queue_frames), "ms", 3},
               {"stays", ms * static_cast<double>(stays), "ms", 3},
               {"ramp", 5., "ms", 3},
               {"aborts", static_cast<double>(t.silent_ms.size()), "", 6},
               {"taken back", t.taken_ms / static_cast<double>(t.silent_ms.size()), "ms", 3},
               {"silent p50", quantile(t.silent_ms, 0.5), "ms", 3},
               {"p99", quantile(t.silent_ms, 0.99), "ms", 3},
               {"worst", quantile(t.silent_ms, 1), "ms", 3},
               {"largest step", t.largest_step, "V", 3},
               {"of drive and ramp", t.own_step, "V", 3},
               {"samples", t.samples, "", 9},
               {"not as recorded", static_cast<double>(t.wrong)},
               {"aborts beside underruns", static_cast<double>(t.disturbed), "", 6},
               {"aborts beside stalls", static_cast<double>(t.stalled), "", 6},
               {"underruns", static_cast<double>(t.underruns)},
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
