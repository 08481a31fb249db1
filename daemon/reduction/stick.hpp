#pragma once
// Intervals of the period in which the walker rests on the base.
#include <cmath>
#include <span>
#include <vector>

#include "daemon/reduction/kinked_motion.hpp"

namespace shaker::reduction {

/// Stick intervals of a cycle, found wherever the relative velocity comes near zero.
/// Model, for the walker's position x at phase p, t in s from the nearer end: slip before `from`, x =
/// x_B(from) + v_B(from) t + a_1 t^2/2 + c; stick between, x = x_B(p) + c; slip after `to`, x = x_B(to) +
/// v_B(to) t + a_2 t^2/2 + c. Fitted: from, to, c, a_1, a_2. Alternative: from = to, a crossing at which the
/// acceleration jumps.
/// A stick is reported when it lowers chi^2 by more than 20 times chi^2 per degree of freedom, and when the
/// friction seen in the slips can hold the base's acceleration within it. A walker whose relative velocity is
/// noise during the whole period gives {0, 1} where v_D is zero within 3 sigma; else it moves by slips that
/// are too short to be seen, and no stick is reported.
///
/// Resolution at 1000 frames/s, 20 Hz, mu 0.113: with 2 um noise and 40 periods, sticks of 0.015 T at 50 g
/// and of 0.15 T at 0.7 g; with 6 periods 0.08 T at 2 g, and half of those of 0.2 T at 0.5 g; 0.03 T at 1.5 g
/// with 6 periods and two views at 0.3 um, but not at 1 um. sd is at least half a frame: a slip shorter than
/// about a frame next to a stick (2 g, phi pi/2: 0.02 T) is counted as part of the stick.
struct Sticks {
    std::vector<StickInterval> found;
    /// Length, in units of the period, from which 19 of 20 sticks about a crossing pass the threshold of 20,
    /// with the phases and errors of these positions: it lowers chi^2 per degree of freedom by 37.5 on
    /// average. At least the time between two frames. The largest over the crossings without a stick; 1 where
    /// the positions are too few or the slips are not seen; NaN without such a crossing.
    double shortest_visible = NAN;
    std::vector<Kink> kinks;  // ends of sticks, and crossings, in order of phase
};
Sticks find_sticks(std::span<const Folded> folded, const Cycle& cycle, const BaseCycle& base,
                   const calibration::Estimate& v_D, double frames_per_period);

}  // namespace shaker::reduction
