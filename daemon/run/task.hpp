#pragma once
// What a drive is for: a number of measurements, or only a move of the walker.
#include "drivers/point_fields.hpp"

namespace shaker::run {

struct Task {
    MeasurementPlan plan{};
    bool identifies = true;  // from rest: the response of the base first, if it is not known
    bool operator==(const Task&) const = default;
};

/// A measurement that is ended before its time keeps its whole periods when it has at least as many.
inline constexpr int least_kept_periods = 5;

}  // namespace shaker::run
