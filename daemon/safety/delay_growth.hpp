#pragma once
// DelayGrowth: by how much a delay exceeds its least value, also when it is measured between two clocks of
// different rates. Real-time.
#include <algorithm>
#include <limits>
#include <utility>

namespace shaker::safety {

/// The least delay is a line m(t) = m0 + r t. It is set from the delays after the first second, in which
/// buffers fill and empty. The rate r is measured between the first and the last quarter of `learn_s`. Later
/// the line follows the delay, up by at most `most_drift` s/s and down by at most 0.1 s/s: a delay that
/// falls for a moment is not a new least value, and a drift of the clocks is not a growth.
class DelayGrowth {
public:
    /// learn_s: s, time in which r is measured; 0: one clock measures both ends, r = 0. most_drift: largest
    /// change of r that is not a growth, s/s.
    constexpr DelayGrowth(double learn_s, double most_drift) noexcept
        : learn_s_{learn_s}, most_drift_{most_drift} {}

    /// Delay at a time above the least delay, s; 0 while that is not known. Any constant may be added to the
    /// delays. Call it at least a few times a second.
    double add(double now_s, double delay_s) noexcept {
        if (!begun_) known_from_s_ = now_s + settle_s;
        const double step_s = std::exchange(begun_, true) ? std::max(0.0, now_s - last_s_) : 0;
        last_s_ = now_s;
        const double since_s = now_s - known_from_s_;
        if (since_s < 0) return 0;
        if (!known_) {
            if (since_s <= 0.25 * learn_s_) first_s_ = std::min(first_s_, delay_s);
            if (since_s >= 0.75 * learn_s_) least_s_ = std::min(least_s_, delay_s);
            if (since_s < learn_s_) return 0;
            known_ = true;
            if (learn_s_ > 0) rate_ = (least_s_ - first_s_) / (0.75 * learn_s_);
        }
        least_s_ += rate_ * step_s;
        least_s_ += std::clamp(delay_s - least_s_, -fall * step_s, most_drift_ * step_s);
        return delay_s - least_s_;
    }

private:
    static constexpr double settle_s = 1, fall = 0.1;

    double learn_s_, most_drift_;
    bool begun_ = false, known_ = false;
    double last_s_ = 0, known_from_s_ = 0;
    double first_s_ = std::numeric_limits<double>::infinity(), least_s_ = first_s_;
    double rate_ = 0;  // s/s
};

}  // namespace shaker::safety
