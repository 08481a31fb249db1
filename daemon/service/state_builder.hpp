#pragma once
// Gathers the published state of the bench from sequence, acquisition and devices, and adds samples to the
// live feed.
#include "daemon/acquisition/collector.hpp"
#include "daemon/bench/bench.hpp"
#include "daemon/run/sequence.hpp"
#include "daemon/service/bench_port.hpp"

namespace shaker::service {

class StateBuilder {
public:
    StateBuilder(const bench::Bench& bench, acquisition::Collector& collector, const run::Sequence& sequence,
                 LiveFeed& feed)
        : bench_{bench}, collector_{collector}, sequence_{sequence}, feed_{feed} {}

    /// Adds the data that arrived since the last call to the feed.
    void feed(const acquisition::Streams& streams);
    /// Fills in the values of sequence, acquisition and devices.
    void fill(BenchState& state, const safety::Limits& limits) const;

    /// Largest values in a period against their limits; predicted: at the set-point.
    [[nodiscard]] std::vector<GaugeState> gauges(const std::vector<safety::Demand>& predicted,
                                                 const safety::Limits& limits) const;

private:
    void feed_accelerations(const acquisition::Streams& streams);
    void feed_tracks(const acquisition::Streams& streams);
    [[nodiscard]] BaseState base() const;
    [[nodiscard]] WaveformState waveform() const;
    [[nodiscard]] std::optional<TrackingState> tracking() const;

    const bench::Bench& bench_;
    acquisition::Collector& collector_;
    const run::Sequence& sequence_;
    LiveFeed& feed_;
    std::size_t blocks_ = 0, walkers_ = 0;  // elements of the streams that were added to the feed
    double base_m_ = 0;                     // newest position of the base
};

}  // namespace shaker::service
