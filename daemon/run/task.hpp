#pragma once
// What a drive is for: a number of measurements, or only a move of the walker.

namespace shaker::run {

struct Task {
    int periods = 40;  // of a measurement; 0: nothing is measured, the drive only moves the walker
    int settle = 0;    // periods of settled drive before a measurement; 0: until the walker's drift is steady
    int times = 0;     // on call: measurements, then the drive is only kept; 0: until the next order
    bool identifies = true;  // from rest: the response of the base first, if it is not known
    bool operator==(const Task&) const = default;
};

/// A measurement that is ended before its time keeps its whole periods when it has at least as many.
inline constexpr int least_kept_periods = 5;

}  // namespace shaker::run
