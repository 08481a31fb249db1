#pragma once
// What a series of measurements tells that no single one can: the drift without the tilt's part, the null
// phase, mu.
#include <optional>
#include <span>

#include "calibration/estimate.hpp"
#include "drivers/drive.hpp"

namespace shaker {

/// A measurement: what was asked for, what was measured.
struct DrivenPoint {
    Drive asked;
    Estimate gamma, phi, v_D;
};

/// A point and the newest before it with the same drive but phi + pi: by symmetry the drift of a level bench
/// turns round.
struct MirrorPair {
    Estimate drift;   // (v(phi) - v(phi + pi)) / 2 of the newer one's phi, m/s: free of what a tilt adds
    Estimate common;  // (v(phi) + v(phi + pi)) / 2: zero on a level bench
};
/// Of the newest point; none before its partner was measured. Points oldest first.
std::optional<MirrorPair> mirror_pair(std::span<const DrivenPoint> points);

/// The null of v_D with dv_D/dphi < 0, and what follows of it for a walker that obeys Coulomb's law
/// (no_stick.hpp).
struct NullPhase {
    Estimate phi0;   // rad
    Estimate theta;  // phi0 - pi/2, rad
    Estimate mu;     // NaN outside the range in which coulomb_theta() is known
};
/// From the newest point and a neighbour in phi on the other side of the null, no farther away than
/// `widest_bracket` and else driven alike, at rho = 1/2: a straight line between the two. sigma holds the
/// errors of v_D and gamma and what the curve's bend may do over the bracket. None without such a pair.
std::optional<NullPhase> null_phase(std::span<const DrivenPoint> points);
inline constexpr double widest_bracket = 0.175;  // rad

}  // namespace shaker
