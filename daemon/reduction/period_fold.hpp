#pragma once
// Drift of each period while a run is in progress.
#include <optional>
#include <span>

#include "calibration/estimate.hpp"

namespace shaker::reduction {

/// Means of positions over whole periods of the drive, as they complete. Bounded memory, no allocation.
class PeriodFold {
public:
    struct Period {
        int k = 0;  // index from the start time; gaps are skipped
        int frames = 0;
        double mean_m = 0;  // of the position, interpolated to the period's ends, for any frame times
        /// D in m: mean minus that of the previous period; NaN without it or with missing frames.
        calibration::Estimate drift;
    };

    /// Periods begin at start_s + k period_s. Positions before start_s are ignored.
    PeriodFold(double start_s, double period_s) noexcept : start_s_(start_s), period_s_(period_s) {}
    /// Adds a position; times must increase. A time before the previous one means that a clock was corrected:
    /// the current period is discarded and the fold restarts there. Returns a period when this position lies
    /// after its end.
    std::optional<Period> add(double t_s, double x_m, double sd_m) noexcept;

private:
    void enter(int k) noexcept;
    std::optional<Period> finish(double t_s, double x_m) noexcept;

    double start_s_, period_s_;
    int k_ = -1;  // current period; -1: none
    int frames_ = 0, most_frames_ = 0;
    double area_ = 0, variance_ = 0;
    bool whole_ = false;  // entered from the previous period
    double last_t_ = 0, last_x_ = 0;
    bool any_ = false;
    std::optional<Period> before_;
    double before_variance_ = 0;
};

/// True when the walker has settled: the last 6 drifts agree within their errors. All of: each of the last 3
/// changes is within 3 sigma sqrt 2; the mean of the last 3 is within 2 sigma sqrt(2/3) of that of the 3
/// before; the last 5 changes do not all have the same sign (a slow approach may stay below sigma in each
/// step). For an approach by a factor of 0.7 per period, the remainder is then below 2 sigma. sigma > 0:
/// standard deviation of one D, or the requested precision if larger. Where the newest drifts scatter about a
/// smooth approach by more than twice that, the same for 12 of them by their scatter: what then is left of an
/// approach lies within it, as long as that takes no more than some 10 periods. False for fewer than 6 values
/// or non-finite ones.
bool settled(std::span<const double> D, double sigma) noexcept;

}  // namespace shaker::reduction
