#pragma once
// DriveHistory: harmonics and phase of the drive at any time, from the changes as they were applied.
#include <deque>

#include "drivers/synthesiser.hpp"

namespace shaker::control {

class DriveHistory {
public:
    /// Silent at phase 0 and this frequency from sample 0 on.
    DriveHistory(double rate_hz, double frequency);

    /// Appends a change; call in the order of application. Changes that it voids are forgotten. Keeps the
    /// newest few hundred. A stop during a ramp is treated as one at the ramp's end: both are followed by
    /// silence.
    void add(const DriveChange& change);

    /// Phase of the drive in turns, whole turns included, at master time at_s.
    [[nodiscard]] double turns(double at_s) const;
    /// Mean harmonics over a span; ramps are weighted.
    [[nodiscard]] Harmonics<Voltage> mean(double from_s, double to_s) const;
    /// True if the span has no ramp and no change.
    [[nodiscard]] bool steady(double from_s, double to_s) const;
    /// Frequency of the newest change, Hz, and the sequence number of its command.
    [[nodiscard]] double frequency() const { return changes_.back().frequency; }
    [[nodiscard]] std::uint64_t sequence() const { return changes_.back().sequence; }
    /// Master time at which the newest change was complete, s.
    [[nodiscard]] double in_force_s() const { return changes_.back().end_s; }

private:
    struct Change {
        Harmonics<Voltage> volts;
        double frequency = 0;
        std::uint64_t sequence = 0;
        double begin_s = 0, end_s = 0;  // of the ramp
        double begin_turns = 0, end_turns = 0;
    };
    void append(const Change& c);

    double rate_hz_;
    std::deque<Change> changes_;
};

}  // namespace shaker::control
