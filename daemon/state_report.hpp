#pragma once
// What the bench is at, gathered from all who know a part of it: ten times a second for the desk, sample by
// sample for its feed.
#include "daemon/acquisition.hpp"
#include "daemon/desk.hpp"
#include "daemon/director.hpp"
#include "daemon/rigs.hpp"

namespace shaker {

class StateReport {
public:
    StateReport(const OpenRig& bench, Acquisition& acquisition, const Director& director, LiveFeed& feed)
        : bench_{bench}, acquisition_{acquisition}, director_{director}, feed_{feed} {}

    /// Adds what came since the last call to the feed.
    void feed(const Take& take);
    /// Fills in what director, acquisition and devices know.
    void fill(BenchState& state) const;

private:
    void feed_accelerations(const Take& take);
    void feed_tracks(const Take& take);
    [[nodiscard]] BaseState base() const;
    [[nodiscard]] WaveformState waveform() const;

    const OpenRig& bench_;
    Acquisition& acquisition_;
    const Director& director_;
    LiveFeed& feed_;
    std::size_t blocks_ = 0, walkers_ = 0;  // of the take, that were fed
    double base_m_ = 0;                     // newest
};

}  // namespace shaker
