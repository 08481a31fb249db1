#pragma once
// An independent walker under any law of friction, for points of campaigns: fixed small steps, no closed
// form.
#include "daemon/law/law_cycle.hpp"

namespace shaker::test {

/// Settled motion on a base that moves with `free` (m/s^2) but for the push of the walker.
struct SteppedCycle {
    double v_D = 0;                  // m/s
    Harmonics<Acceleration> base{};  // harmonics 1 to 16 of the pushed base
};

/// Runge and Kutta's method of fourth order with `steps` a period; the end of a slip is interpolated. factor:
/// of mu at this point. The cycle repeats to 1e-9 m/s.
SteppedCycle stepped_cycle(const Harmonics<Acceleration>& free, double frequency, const law::LawSetting& law,
                           double factor, int steps);

/// A point as a campaign measures it, without noise: v_D and harmonics of that walker with errors as on the
/// simulated bench.
law::Point stepped_point(const Drive& asked, const law::LawSetting& law, int number, int partner,
                         double time_s, double place, int steps = 40'000);

/// phi = 0 and a phase near the null at three gammas, with mirror partners: 12 points in two minutes.
std::vector<law::Point> stepped_points(const law::LawSetting& law, int steps = 40'000);

}  // namespace shaker::test
