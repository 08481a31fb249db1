#pragma once
// The cycle into which a walker settles.
#include <array>
#include <cstdint>
#include <vector>

#include "drivers/walker/integrated_walker.hpp"

namespace shaker::walker {

/// Walker at rest on the base, phases t/T; `to` exceeds 1 when the interval wraps.
struct RestInterval {
    double from = 0;
    double to = 0;
};

/// One period of the settled motion. v has one value per phase and two walkers never overtake each other, so
/// the velocity at phase 0 changes monotonically from period to period: the cycle always has the period of
/// the drive.
struct SteadyState {
    double v_D = 0;                     // m/s
    double D = 0;                       // m per period
    double v0 = 0;                      // m/s, at phase 0
    Contact contact0 = Contact::stick;  // at phase 0
    std::vector<WalkerEvent> events;    // of one period, by phase
    std::vector<RestInterval> rest;
    double rest_fraction = 0;  // of the period
    std::int64_t periods = 0;  // until the motion repeated within 1e-14 gamma/omega
    double contraction = 0;    // factor per period of a small error of v; 0 if the walker sticks
};

/// The cycle reached from velocity v_start (m/s) at phase 0. With mu_s > mu_k there may be two, each with its
/// own range of start velocities. Throws InputError when there is none: the tilt exceeds the angle of
/// friction, or the walker needs more than 10^7 periods.
SteadyState settle(const WalkerLaw& law, double v_start = 0);
/// The same in a few periods instead of hundreds, to 1e-12 gamma/omega: Newton's method on v(T) - v(0), which
/// falls monotonically. For mu_s = mu_k. Its `periods` has no meaning.
SteadyState settle_quickly(const WalkerLaw& law, double v_start);
/// The same by integration, for any law of friction without roughness; errors of v_D are about 100 times the
/// walker's tolerance. The contraction is the ratio of the last changes of v from period to period.
SteadyState settle(IntegratedWalker& walker);
/// Where a nearby cycle begins, and what a period makes of small changes there: inverse of the derivative of
/// the change in a period of v over gamma/omega and of zeta.
struct WarmStart {
    double v = 0, zeta = 0;  // m/s, 1
    std::array<std::array<double, 2>, 2> inverse{{{-1, 0}, {0, -1}}};
};
/// The same in some four periods, or two from the start of a nearby cycle, by Broyden's method: to 1e-8
/// gamma/omega, or to 1e-6 where the error of the integration hides it for 40 periods. `start` becomes that
/// of this cycle. `periods` and `contraction` have no meaning. InputError after 400 periods.
SteadyState settle_quickly(IntegratedWalker& walker, WarmStart& start);
/// The cycle under any law: exact where slip has a closed form. Throws InputError for friction that does not
/// repeat: mu that changes from period to period, or a rough surface.
SteadyState settle(const WalkerSetting& setting, double v_start = 0);

}  // namespace shaker::walker
