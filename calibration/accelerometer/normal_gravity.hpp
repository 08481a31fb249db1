#pragma once
// Gravity of a place from its latitude and height.
#include "calibration/estimate.hpp"

namespace shaker::calibration {

/// Normal gravity of the WGS 84 ellipsoid (Somigliana's closed formula) with the second-order free-air
/// correction, m/s^2. latitude: geodetic, rad; height: above the ellipsoid, m (height above the sea will do:
/// 100 m are 3e-4 m/s^2). sigma is the usual gravity anomaly, 3e-4 m/s^2 (30 mGal); in mountains it reaches
/// three times that. National surveys publish better values.
Estimate normal_gravity(double latitude, double height) noexcept;

}  // namespace shaker::calibration
