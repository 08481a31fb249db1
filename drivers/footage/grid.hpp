#pragma once
// Regular times with whole gaps, found in stamps that are rounded or jitter.
#include <cstdint>
#include <vector>

namespace shaker::footage {

/// Straight line through stamps, by their numbers.
struct Grid {
    std::vector<std::int64_t> ticks;  // of each stamp; the first has 0, missing ones leave a gap
    double first_s = 0, step_s = 0;   // of the line
    double off_s = 0;                 // largest distance of a stamp from it
};

/// Mean of the steps between neighbours that are near the median one, s. Stamps are rounded ("0.000333"), so
/// a single step, or the median, may be wrong by enough to miscount a long gap. t_s: at least two,
/// increasing.
double usual_step(const std::vector<double>& t_s);

/// Numbers the stamps by steps of about `step_s`, and fits the line to all. t_s: increasing.
Grid fitted_grid(const std::vector<double>& t_s, double step_s);

}  // namespace shaker::footage
