#pragma once
// Measurements of one set-point as one result.
#include <cmath>
#include <span>
#include <string>
#include <vector>

#include "daemon/catalogue/results_table.hpp"

namespace shaker::catalogue {

/// The steady rows of equal set-points, combined as the passes of a campaign's point (reduction/series.hpp).
struct Repeats {
    Drive asked;
    std::string newest;         // time of the newest row
    int count = 0;              // rows whose v_D has an error
    calibration::Estimate v_D;  // m/s
    calibration::Estimate D;    // m per period
    calibration::Estimate efficiency;
    double stated = NAN;   // error of v_D of one row, root mean square, m/s
    double scatter = NAN;  // standard deviation of v_D of one row, m/s; NaN for one row
};

/// In the order of their newest rows, the newest first. `rows`: in order of time.
std::vector<Repeats> repeats_of(std::span<const NumberedRow> rows);

}  // namespace shaker::catalogue
