#pragma once
// The walker's velocity over one period where its acceleration jumps: no smoothing across the jumps.
#include <span>
#include <vector>

#include "daemon/reduction/cycle.hpp"

namespace shaker::reduction {

/// A phase at which the walker's acceleration changes quickly: a slip ends or begins.
struct Kink {
    double phase = 0;          // 0..1
    double reach = 0;          // it lies within phase +- reach, in periods
    double longest = 0;        // the change may take this long, in periods
    bool rests_after = false;  // the walker rests on the base from here to the next kink
};

struct KinkedMotion {
    std::vector<calibration::Estimate> v;  // m/s, at the phases of the first estimate
    std::vector<Flip> flips;               // kinks between slips, known to half a frame and apart from others
};

/// Model: between kinks the acceleration is a Wiener process (of its own in slip, about the base's in rest),
/// the faster the smaller |v_R| is; at a kink it changes by about 6 (v_max - v_min)/T (standard deviation)
/// within an interval of which neither place nor length is known. The positions show how probable each place
/// and length is, and how much the acceleration varies between kinks; v is the mean of Kalman smoothers over
/// 16 probable sets of them, and its error contains their scatter: where an interval is shorter than the
/// frames resolve, v is as uncertain as what may happen in it. On drives drawn by a seed, under four laws of
/// friction, 500 and 1000 frames/s, 40 periods, 2 um: +-2 errors contain v at 94 to 99 % of the phases within
/// 2.5 frames of a kink and at 92 to 99 % of the others; its rms error is 0.10 to 0.17 mm/s and 0.04 to 0.07
/// mm/s.
/// folded: in order of phase. kinks: in order of phase. smoothed: a first estimate of the motion, and how far
/// the positions scatter. exposure_s: positions are means over it.
KinkedMotion kinked_motion(std::span<const Folded> folded, std::span<const Kink> kinks, const BaseCycle& base,
                           double v_D, const SmoothedCycle& smoothed, double frames_per_period,
                           double exposure_s);

}  // namespace shaker::reduction
