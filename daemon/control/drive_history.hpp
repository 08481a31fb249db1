#pragma once
// What was played when: the drive's harmonics and its phase at any instant, from the changes as they were
// applied.
#include <deque>

#include "drivers/synthesiser.hpp"

namespace shaker {

class DriveHistory {
public:
    /// Silent at phase 0 and this frequency from sample 0 on.
    DriveHistory(double rate_hz, double frequency);

    /// In the order in which they were applied. The newest few hundred are kept. A stop in the middle of a
    /// ramp counts as one from the ramp's end: what comes after it is silence either way.
    void add(const DriveChange& change);

    /// Turns of the drive's phase at an instant, s of master time, whole ones counted.
    [[nodiscard]] double turns(double at_s) const;
    /// Mean harmonics over a span; of a ramp its share.
    [[nodiscard]] Harmonics<Voltage> mean(double from_s, double to_s) const;
    /// No ramp and no change in the span.
    [[nodiscard]] bool steady(double from_s, double to_s) const;
    /// Frequency that was told last, Hz, and the command's number.
    [[nodiscard]] double frequency() const { return changes_.back().frequency; }
    [[nodiscard]] std::uint64_t sequence() const { return changes_.back().sequence; }
    /// When the newest change was wholly in force, s.
    [[nodiscard]] double in_force_s() const { return changes_.back().end_s; }

private:
    struct Change {
        Harmonics<Voltage> volts;
        double frequency = 0;
        std::uint64_t sequence = 0;
        double begin_s = 0, end_s = 0;  // of the ramp
        double begin_turns = 0, end_turns = 0;
    };
    double rate_hz_;
    std::deque<Change> changes_;
};

}  // namespace shaker
