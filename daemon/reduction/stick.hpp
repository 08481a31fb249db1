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
/// 20 and the base's acceleration within it could be held by the friction that the slips show. A walker whose
/// relative velocity is noise all through the period gives {0, 1}.
///
/// What can be seen, at 1000 frames/s, 20 Hz, mu 0.113: with 2 um noise and 40 periods, sticks of 0.015 T at
/// 50 g and of 0.15 T at 0.7 g; with 6 periods 0.08 T at 2 g, and half of those of 0.2 T at 0.5 g; 0.03 T
/// at 1.5 g is seen with 6 periods and two views at 0.3 um, not at 1 um. sd is at least half a frame: a slip
/// shorter than about a frame next to a stick (2 g, phi pi/2: 0.02 T) is counted with the stick.
std::vector<StickInterval> find_sticks(std::span<const Folded> folded, const Cycle& cycle,
                                       const BaseCycle& base, double v_D, double frames_per_period);

}  // namespace shaker
