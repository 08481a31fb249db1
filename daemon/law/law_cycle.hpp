#pragma once
// The settled motion of a walker that pushes the base it slips on, under any law of friction.
#include "daemon/law/laws.hpp"
#include "daemon/law/pushed_walker.hpp"
#include "drivers/walker/steady_state.hpp"

namespace shaker::law {

struct LawCycle {
    double v_D = NAN;  // m/s
    walker::WarmStart start{};
    Amplitudes walker{};  // harmonics 1 to 16 of the walker's acceleration, m/s^2
};

/// The cycle at a point. `since`: time since the first point, s. tolerance: of the integrator, relative to
/// (gamma + g)/omega a step; the error of v_D is about 100 times that. The base without the push follows from
/// `start`, the cycle of a nearby setting, or by iteration. InputError where there is no settled motion.
LawCycle law_cycle(const Point& point, double since, const LawSetting& setting, double tolerance,
                   const LawCycle* start = nullptr);

}  // namespace shaker::law
