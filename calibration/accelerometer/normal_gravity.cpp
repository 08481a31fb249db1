#include "calibration/accelerometer/normal_gravity.hpp"

#include <cmath>

namespace shaker::calibration {

Estimate normal_gravity(double latitude, double height) noexcept {
    // WGS 84 (NIMA TR8350.2): equatorial gravity, Somigliana's constant, eccentricity^2, semi-major axis,
    // flattening, and m = omega^2 a^2 b / GM.
    constexpr double at_equator = 9.7803253359, k = 0.00193185265241, e2 = 0.00669437999013, a = 6378137,
                     f = 1 / 298.257223563, m = 0.00344978650684, anomaly = 3e-4;
    const double s2 = std::pow(std::sin(latitude), 2);
    const double on_ellipsoid = at_equator * (1 + k * s2) / std::sqrt(1 - e2 * s2);
    const double h = height / a;
    return {on_ellipsoid * (1 - 2 * (1 + f + m - 2 * f * s2) * h + 3 * h * h), anomaly};
}

}  // namespace shaker::calibration
