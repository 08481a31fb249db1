#pragma once
// What the check of a plan needs to know of a bench.
#include <vector>

#include "daemon/bench/bench.hpp"
#include "daemon/campaign/plan_check.hpp"

namespace shaker::campaign {

/// Walker, limits and swing of the base at each drive of the points. Does not refer to the bench afterwards.
/// The caller adds the length of the view, and the walker's place where it is known.
CheckSettings check_settings(const Plan& plan, const std::vector<Point>& points, const bench::Bench& bench);

}  // namespace shaker::campaign
