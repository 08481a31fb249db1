#pragma once
// Tumble calibration: gain matrix and offsets of a three-axis accelerometer from attitudes at rest.
#include <array>
#include <span>
#include <string>
#include <vector>

#include "calibration/accelerometer/attitudes.hpp"
#include "calibration/estimate.hpp"

namespace shaker::calibration {

/// Rows: the sensor's axes as marked; columns: the axes of the counts.
using Matrix = std::array<std::array<double, 3>, 3>;

/// The largest condition number of the normal equations of a set of attitudes that is fitted.
inline constexpr double worst_condition = 1000;

/// a = gain (counts + offset_counts), m/s^2, specific force as AccelerometerInfo::acceleration() defines it.
///
/// At rest |a| is the local gravity in every attitude, so the attitudes themselves need not be known. That
/// leaves a rotation of `gain` open. It is chosen so that gain = T P diag(nominal) with T symmetric and
/// positive and P a signed permutation (identity unless axes are exchanged or reversed): the axes of no other
/// choice lie closer to those of the counts.
///
/// Errors are those of a relative gain tensor E and a residual b: true a = (I + E) a + b. `covariance`, 9 x 9
/// by rows, is that of (E_xx, E_yy, E_zz, E_xy, E_xz, E_yz, b_x/g, b_y/g, b_z/g) by noise alone; the error of
/// gravity scales E_xx, E_yy and E_zz together and is not in it.
struct Tumble {
    Matrix gain{};           // m/s^2 per count
    Vector offset_counts{};  // counts
    std::array<double, 81> covariance{};
    Estimate gravity{};  // m/s^2, at the place
    int attitudes = 0;
    double condition = 0;  // of the normal equations
    double chi2 = 0;       // sum of squared residuals over their variances
    int degrees_of_freedom = 0;
    double chance = 0;                    // of a chi2 at least as large
    double rms_residual = 0;              // of |a|, m/s^2
    std::vector<std::string> findings{};  // exchanged or reversed axes, a doubtful fit; one sentence each

    /// Relative standard error of the gain along u (unit vector), that of gravity included.
    [[nodiscard]] double gain_error(const Vector& u) const noexcept;
    /// Standard error of the component along u (unit vector) of a reading a at rest, m/s^2: of u . (E a + b),
    /// with the error of gravity.
    [[nodiscard]] double reading_error(const Vector& u, const Vector& a) const noexcept;
    /// Standard errors of the offsets, counts, by noise alone.
    [[nodiscard]] Vector offset_errors() const noexcept;
};

/// Condition number of the normal equations for attitudes with these directions of up; infinite for fewer
/// than nine.
double condition_of(std::span<const Vector> directions);

/// Directions of up by the nominal scales, unit vectors.
std::vector<Vector> nominal_directions(std::span<const Attitude> attitudes, const Vector& nominal);

/// Scales, m/s^2 per count, from the largest reading of each axis: within a few percent if each axis pointed
/// up or down once.
Vector guessed_scales(std::span<const Attitude> attitudes, double gravity);

/// Fits attitudes. nominal: m/s^2 per count of each axis, with its sign. Weights are the scatter of the
/// records. A chi2 with a chance below 1e-4 widens the errors by sqrt(chi2 / degrees of freedom). InputError
/// names: an attitude in which the sensor moved; one held far from its name; attitudes that are missing when
/// the condition number exceeds worst_condition; a set whose |a| scatters by more than 1e-3 g.
Tumble fit_tumble(std::span<const Attitude> attitudes, const Vector& nominal, const Estimate& gravity);

/// Normal gravity of the WGS 84 ellipsoid (Somigliana's closed formula) with the second-order free-air
/// correction, m/s^2. latitude: geodetic, rad; height: above the ellipsoid, m (height above the sea will do:
/// 100 m are 3e-4 m/s^2). sigma is the usual gravity anomaly, 3e-4 m/s^2 (30 mGal); in mountains it reaches
/// three times that. National surveys publish better values.
Estimate normal_gravity(double latitude, double height) noexcept;

}  // namespace shaker::calibration
