#pragma once
// Results from several measurements: drift without the effect of tilt, null phase.
#include <optional>
#include <span>

#include "calibration/estimate.hpp"
#include "drivers/drive.hpp"

namespace shaker::reduction {

/// One measurement: requested drive and results.
struct DrivenPoint {
    Drive asked;
    calibration::Estimate gamma, phi, v_D;
};

/// The same biharmonic drive at phi + pi.
bool mirrored(const Drive& a, const Drive& b);

/// A point and the newest earlier one with the same drive at phi + pi. By symmetry, the drift on a level
/// bench changes its sign.
struct MirrorPair {
    calibration::Estimate
        drift;  // (v(phi) - v(phi + pi)) / 2 at the newer point's phi, m/s: without the effect of tilt
    calibration::Estimate common;  // (v(phi) + v(phi + pi)) / 2, m/s: zero on a level bench
};
/// For the newest point; empty until its partner (phi + pi) has been measured. Points in order of time.
std::optional<MirrorPair> mirror_pair(std::span<const DrivenPoint> points);

/// The null of v_D with dv_D/dphi < 0.
struct NullPhase {
    calibration::Estimate phi0;   // rad
    calibration::Estimate theta;  // phi0 - pi/2, rad
};
/// Linear interpolation between the newest point and a neighbour in phi on the other side of the null, at
/// most `widest_bracket` away, with the same drive and rho = 1/2. sigma includes the errors of v_D and the
/// possible curvature over the bracket. Empty without such a pair.
std::optional<NullPhase> null_phase(std::span<const DrivenPoint> points);
inline constexpr double widest_bracket = 0.175;  // rad

}  // namespace shaker::reduction
