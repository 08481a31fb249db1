#pragma once
// What the bench is at, gathered from all who know a part of it: ten times a second for the desk, sample by
// sample for its feed.
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

    /// Adds what came since the last call to the feed.
    void feed(const acquisition::Streams& streams);
    /// Fills in what director, acquisition and devices know.
    void fill(BenchState& state) const;

private:
    void feed_accelerations(const acquisition::Streams& streams);
    void feed_tracks(const acquisition::Streams& streams);
    [[nodiscard]] BaseState base() const;
    [[nodiscard]] WaveformState waveform() const;

    const bench::Bench& bench_;
    acquisition::Collector& collector_;
    const run::Sequence& sequence_;
    LiveFeed& feed_;
    std::size_t blocks_ = 0, walkers_ = 0;  // of the take, that were fed
    double base_m_ = 0;                     // newest
};

}  // namespace shaker::service
