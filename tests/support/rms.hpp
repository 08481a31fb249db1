#pragma once
// The scatter of a list of numbers.
#include <cmath>
#include <span>

namespace shaker::test {

/// Root of the mean squared difference from the mean, in the unit of the values; at least one value.
inline double rms_about_mean(std::span<const double> values) {
    const auto count = static_cast<double>(values.size());
    double mean = 0, squares = 0;
    for (const double v : values) mean += v / count;
    for (const double v : values) squares += (v - mean) * (v - mean);
    return std::sqrt(squares / count);
}

}  // namespace shaker::test
