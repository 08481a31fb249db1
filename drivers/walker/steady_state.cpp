#include "drivers/walker/steady_state.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/errors.hpp"

namespace shaker::walker {

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

/// Fills in the values that follow from D, contact0 and the events of the period.
void describe(SteadyState& state, double period, std::span<const WalkerEvent> events) {
    state.v_D = state.D / period;
    state.events.assign(events.begin(), events.end());
    state.rest = rest_intervals(state.events, state.contact0);
    for (const RestInterval& r : state.rest) state.rest_fraction += r.to - r.from;
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
    describe(state, law.period(), walker.events());
    return state;
}

SteadyState settle_quickly(const WalkerLaw& law, double v_start) {
    constexpr int most_steps = 60;
    constexpr double repeats_quickly = 1e-12, slowest = 0.999;  // of gamma/omega; a period
    SteadyState state;
    state.v0 = v_start;
    for (int step = 0; step < most_steps; ++step) {
        Walker walker{law, state.v0};
        state.contact0 = walker.now().contact;
        state.D = walker.advance_period();
        const double change = walker.now().v - state.v0;
        state.contraction = contraction(law, walker.events(), walker.now().contact);
        if (std::abs(change) <= repeats_quickly * law.velocity_scale()) {
            describe(state, law.period(), walker.events());
            return state;
        }
        if (walker.events().empty()) break;
        state.v0 += change / (1 - std::clamp(state.contraction, 0.0, slowest));
    }
    return settle(law, state.v0);
}

SteadyState settle(IntegratedWalker& walker) {
    constexpr std::int64_t most_integrated = 100'000;
    constexpr double settled_v = 1e-8, noise = 1e-9, slowest = 0.9999;  // of gamma/omega; a period
    const double scale = walker.velocity_scale();
    SteadyState state;
    double change_before = 0;
    for (std::int64_t n = 0; n < most_integrated; ++n) {
        state.v0 = walker.now().v;
        state.contact0 = walker.now().contact;
        state.D = walker.advance_period();
        const double change = std::abs(walker.now().v - state.v0);
        if (change > noise * scale)
            state.contraction = n == 0 ? 0 : std::min(change / change_before, slowest);
        change_before = change;
        if (change > settled_v * scale * (1 - state.contraction)) continue;
        state.periods = n;
        describe(state, 1 / walker.setting().frequency, walker.events());
        return state;
    }
    throw InputError{"the walker has not settled after 100000 periods of the drive"};
}

SteadyState settle_quickly(IntegratedWalker& walker, WarmStart& start) {
    constexpr int most_steps = 400, many_steps = 40;
    constexpr double least = 1e-8, noisy = 1e-6, longest = 1;  // of gamma/omega, and of zeta
    const double scale = walker.velocity_scale();
    walker.jump_to(start.v, start.zeta);
    SteadyState state;
    std::array<double, 2> before{}, step{};
    auto& H = start.inverse;
    for (int n = 0; n < most_steps; ++n) {
        start.v = state.v0 = walker.now().v;
        start.zeta = walker.zeta();
        state.contact0 = walker.now().contact;
        state.D = walker.advance_period();
        const std::array<double, 2> change{(walker.now().v - start.v) / scale, walker.zeta() - start.zeta};
        if (n > 0) {  // Broyden's update
            const std::array<double, 2> d{change[0] - before[0], change[1] - before[1]},
                Hd{H[0][0] * d[0] + H[0][1] * d[1], H[1][0] * d[0] + H[1][1] * d[1]},
                sH{step[0] * H[0][0] + step[1] * H[1][0], step[0] * H[0][1] + step[1] * H[1][1]};
            const double by = step[0] * Hd[0] + step[1] * Hd[1];
            for (std::size_t i = 0; i < 2 && by != 0; ++i)
                for (std::size_t k = 0; k < 2; ++k) H[i][k] += (step[i] - Hd[i]) * sH[k] / by;
        }
        before = change;
        for (std::size_t i = 0; i < 2; ++i)
            step[i] = std::clamp(-H[i][0] * change[0] - H[i][1] * change[1], -longest, longest);
        const double enough = n < many_steps ? least : noisy;
        if (std::abs(step[0]) <= enough && std::abs(change[0]) <= enough) {
            describe(state, 1 / walker.setting().frequency, walker.events());
            return state;
        }
        const bool forgets = n % many_steps == many_steps - 1;  // what it learned of the derivative
        if (forgets) start = {start.v, start.zeta};
        if (forgets || !walker.jump_to(start.v + step[0] * scale, start.zeta + step[1]))
            step = change;  // it goes on as it is
    }
    throw InputError{"the walker has not settled after 400 periods of the drive"};
}

SteadyState settle(const WalkerSetting& setting, double v_start) {
    const Friction& friction = setting.friction;
    if (!friction.change.none() || friction.roughness.share != 0)
        throw InputError{"no two periods are equal: mu changes from period to period or from place to place"};
    if (friction.closed_form()) return settle(WalkerLaw{setting}, v_start);
    IntegratedWalker walker{setting, v_start};
    return settle(walker);
}

}  // namespace shaker::walker
