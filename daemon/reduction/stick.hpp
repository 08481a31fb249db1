#pragma once
// Where in the period the walker rests on the base.
#include <span>
#include <vector>

#include "daemon/reduction/cycle.hpp"

namespace shaker {

/// Stick intervals of a cycle. Wherever the relative velocity comes near zero, the folded positions are
/// fitted by slip at a constant acceleration until `from`, the base's motion until `to`, slip at another
/// constant acceleration from there on, against the same with from = to (a mere crossing, at which the
/// acceleration jumps). A stick is reported when it explains the positions better by chi^2 / residual chi^2 >
/// 20 and the base's acceleration within it could be held by the friction that the slips show.
std::vector<StickInterval> find_sticks(std::span<const Folded> folded, const Cycle& cycle,
                                       const BaseCycle& base, double v_D);

}  // namespace shaker
