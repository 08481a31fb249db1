#include "drivers/simulated/walker/steady_state.hpp"

#include <cmath>

#include "drivers/errors.hpp"

namespace shaker::simulated {

namespace {

constexpr std::int64_t most_periods = 10'000'000;
constexpr double repeats = 1e-14;   // gamma/omega
constexpr double settled = 1e-14;   // gamma/omega, remaining change of v
constexpr double rounding = 1e-12;  // gamma/omega; a smaller change that does not shrink is rounding

/// Factor of a small error of v over the period of the given events. Where v_R crosses zero the error is
/// multiplied by the ratio of dv_R/dt after and before.
double contraction(const WalkerLaw& law, std::span<const WalkerEvent> events, Contact at_end) {
    if (at_end == Contact::stick) return 0;
    double left = std::exp(-law.setting().friction.viscous * law.period());
    for (const WalkerEvent& e : events) {
        if (e.from == Contact::stick || e.to == Contact::stick) return 0;
        const double phase = two_pi * e.phase;
        left *= law.slip(e.to).f(phase) / law.slip(e.from).f(phase);
    }
    return left;
}

std::vector<RestInterval> rest_intervals(std::span<const WalkerEvent> events, Contact at_start) {
    if (events.empty())
        return at_start == Contact::stick ? std::vector<RestInterval>{{0, 1}} : std::vector<RestInterval>{};
    std::vector<RestInterval> rest;
    for (std::size_t i = 0; i < events.size(); ++i) {
        if (events[i].to != Contact::stick) continue;
        const bool wraps = i + 1 == events.size();
        rest.push_back({events[i].phase, wraps ? events.front().phase + 1 : events[i + 1].phase});
    }
    return rest;
}

}  // namespace

SteadyState settle(const WalkerLaw& law, double v_start) {
    Walker walker{law, v_start};
    const double scale = law.velocity_scale();
    SteadyState state;
    state.periods = -1;
    double change_before = 0;
    for (std::int64_t n = 0;; ++n) {
        if (n == most_periods)
            throw InputError{"the walker has not settled after 10000000 periods of the drive"};
        state.v0 = walker.now().v;
        state.contact0 = walker.now().contact;
        state.D = walker.advance_period();
        const double change = walker.now().v - state.v0;
        if (law.setting().friction.viscous == 0 && walker.events().empty() &&
            state.contact0 != Contact::stick && change * static_cast<double>(state.contact0) > 0) {
            throw InputError{"the walker has no steady motion: at this tilt friction cannot stop it"};
        }
        const bool shrinks = std::abs(change) < std::abs(change_before);
        change_before = change;
        if (state.periods < 0 && std::abs(change) <= repeats * scale) state.periods = n;
        if (std::abs(change) > rounding * scale) continue;
        state.contraction = contraction(law, walker.events(), walker.now().contact);
        if (!shrinks || std::abs(change) <= settled * scale * (1 - state.contraction)) break;
    }
    if (state.periods < 0) state.periods = walker.period() - 1;
    state.v_D = state.D / law.period();
    state.events.assign(walker.events().begin(), walker.events().end());
    state.rest = rest_intervals(state.events, state.contact0);
    for (const RestInterval& r : state.rest) state.rest_fraction += r.to - r.from;
    return state;
}

}  // namespace shaker::simulated
