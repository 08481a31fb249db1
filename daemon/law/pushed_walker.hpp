#pragma once
// The settled motion of a walker that pushes the base it slips on.
#include <array>
#include <complex>
#include <vector>

#include "daemon/law/point.hpp"
#include "drivers/walker/walker.hpp"

namespace shaker::law {

using Amplitudes = std::array<std::complex<double>, max_harmonics>;

/// Slip or stick between two events of the cycle, phases in rad; `to` may exceed 2 pi.
struct Segment {
    double from = 0, to = 0;
    walker::Contact contact = walker::Contact::stick;
};

/// The settled cycle of one point.
struct PushedCycle {
    double v_D = 0;  // m/s
    double v0 = 0;   // m/s, of the walker on the free base at phase 0: a start for the next call
    Harmonics<Acceleration> free{};  // motion of the base without the push of the walker, m/s^2
    Amplitudes walker{};             // harmonics 1 to 16 of the walker's acceleration, m/s^2
    std::vector<Segment> segments;   // of one period, in order, without gaps
    int settles = 0;                 // solved cycles, for the cost
};

/// Model. Friction moves the base by -r a_w, with a_w the acceleration of the walker and r = m/M_eff. A
/// measurement has harmonics 1 to 16 of a_B; the rest of a_B is that of -r a_w, with its jumps where a slip
/// begins and ends:
///     a_B = P + r [a_w]_1..16 - r a_w = Q - r a_w,
/// P: measured harmonics, [ ]: their truncated series. Q, the free base, has 16 harmonics. In slip a_w = g
/// sin b - s mu g cos b, so v_R' = (1 + r) a_w - Q; in stick a_w = a_B = Q/(1 + r). Relative to the base the
/// walker hence moves exactly as one under gravity (1 + r) g on the base Q. Q follows from a_w by iteration.
/// b: tilt. Above harmonic 16 the base is a free mass here; Sensitivity::by_drag() adds its damping.
/// start: the cycle of a nearby law, which saves iterations. Throws InputError when there is no settled
/// motion (tilt beyond the angle of friction).
PushedCycle pushed_cycle(const Harmonics<Acceleration>& measured, double frequency, const Coulomb& law,
                         const PushedCycle* start = nullptr);

/// Harmonics 1 to `last` of a signal that is `slip[0]` in backward slip, `slip[1]` in forward slip and the
/// signal `stick` where the walker sticks.
std::vector<std::complex<double>> segment_harmonics(const std::vector<Segment>& segments,
                                                    const std::array<double, 2>& slip,
                                                    const Harmonics<Acceleration>& stick, int last);
/// The same for harmonics 1 to 16.
Amplitudes segment_harmonics(const std::vector<Segment>& segments, const std::array<double, 2>& slip,
                             const Harmonics<Acceleration>& stick);

/// Acceleration of the slipping walker, m/s^2: backward, forward.
std::array<double, 2> slip_acceleration(const Coulomb& law) noexcept;

}  // namespace shaker::law
