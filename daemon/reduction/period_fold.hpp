#pragma once
// Drift period by period while the run is on.
#include <optional>
#include <span>

#include "calibration/estimate.hpp"

namespace shaker {

/// Means of positions over whole periods of the drive, as they complete. Bounded memory, no allocation.
class PeriodFold {
public:
    struct Period {
        int k = 0;  // from the start time; gaps are skipped
        int frames = 0;
        double mean_m =
            0;           // of the position, interpolated to the period's ends, so that frames need not fit it
        Estimate drift;  // mean minus that of the period before; NaN when there is none or frames are missing
    };

    /// Periods begin at start_s + k period_s; positions before start_s are ignored.
    PeriodFold(double start_s, double period_s) noexcept : start_s_(start_s), period_s_(period_s) {}
    /// The next position; times increase. One that is earlier than the one before tells that a clock was
    /// wrong: what was gathered of the period is forgotten and the fold begins anew there. Returns a period
    /// when this position lies beyond its end.
    std::optional<Period> add(double t_s, double x_m, double sd_m) noexcept;

private:
    void enter(int k) noexcept;
    std::optional<Period> finish(double t_s, double x_m) noexcept;

    double start_s_, period_s_;
    int k_ = -1;  // period in hand; -1: none yet
    int frames_ = 0, most_frames_ = 0;
    double area_ = 0, variance_ = 0;
    bool whole_ = false;  // it was entered from the period before
    double last_t_ = 0, last_x_ = 0;
    bool any_ = false;
    std::optional<Period> before_;
    double before_variance_ = 0;
};

/// The walker has settled: the last 6 drifts differ by no more than their errors explain. Three conditions:
/// each of the last 3 changes is within 3 sigma sqrt 2; the mean of the last 3 is within 2 sigma sqrt(2/3) of
/// that of the 3 before; and the last 5 do not all go the same way (a slow approach hides below sigma step by
/// step). For an approach that shrinks by c = 0.7 a period what is left is then below 2 sigma. sigma > 0:
/// standard deviation of one D, or the precision wanted if that is larger. False for less than 6 values or
/// any that is not finite.
bool settled(std::span<const double> D, double sigma) noexcept;

}  // namespace shaker
