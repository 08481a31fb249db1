#pragma once
// The cycle a walker settles into.
#include <cstdint>
#include <vector>

#include "drivers/simulated/walker.hpp"

namespace shaker {

/// Walker at rest on the base, phases t/T; `to` exceeds 1 when the interval wraps.
struct RestInterval {
    double from = 0;
    double to = 0;
};

/// One period of the settled motion. v has one value at a phase and two walkers never overtake each other, so
/// the velocity at phase 0 moves monotonically from period to period: the cycle always has the period of the
/// drive.
struct SteadyState {
    double v_D = 0;                     // m/s
    double D = 0;                       // m a period
    double v0 = 0;                      // m/s, at phase 0
    Contact contact0 = Contact::stick;  // at phase 0
    std::vector<WalkerEvent> events;    // of one period, by phase
    std::vector<RestInterval> rest;
    double rest_fraction = 0;  // of the period
    std::int64_t periods = 0;  // walked until the motion repeats within 1e-14 gamma/omega
    double contraction = 0;    // of a small error of v, a period; 0 where the walker sticks
};

/// The cycle reached from velocity v_start (m/s) at phase 0. With mu_s > mu_k there may be two, each with its
/// own range of starts. Throws InputError when there is none: a tilt beyond the angle of friction, or one
/// that takes more than 10^7 periods.
SteadyState settle(const WalkerLaw& law, double v_start = 0);

}  // namespace shaker
