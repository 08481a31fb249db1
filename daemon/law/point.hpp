#pragma once
// Point: one measured set-point of a campaign, as the fits to the law of friction need it; and groups of
// points with the same drive but for one quantity.
#include <array>
#include <cmath>
#include <map>
#include <span>
#include <string>
#include <tuple>
#include <vector>

#include "calibration/estimate.hpp"
#include "daemon/reduction/reduction.hpp"
#include "drivers/drive.hpp"

namespace shaker::law {

/// A measured point. Phases of the base's harmonics count from where harmonic 1 has phase 0.
struct Point {
    int number = 0;                               // in its campaign, from 1
    int campaign = 0;                             // index of the campaign
    int partner = 0;                              // number of the mirror partner (phi + pi); 0: none
    std::string series{};                         // name in the plan
    Drive asked{};                                // set-point
    double frequency = 20;                        // Hz, measured
    calibration::Estimate gamma{}, rho{}, phi{};  // m/s^2, 1, rad, measured
    calibration::Estimate v_D{};                  // m/s
    calibration::Estimate tilt{};                 // by gravity, rad; NaN: not known
    double true_v_D = NAN;                        // m/s; NaN: not a simulated bench
    std::string doubt{};                          // note that questions the measurement; empty: none
    int periods = 0;                              // measured
    double time_s = NAN;                          // of its end, from any one instant; NaN: not known
    double place = NAN;                           // of the walker, mean of its passes, m
    Harmonics<Acceleration> base{};               // measured, m/s^2
    std::array<double, max_harmonics> base_sd{};  // of each real and imaginary part, m/s^2
    /// Of phi, rad, beyond the noise of the harmonics: an accelerometer's corner turns harmonic q by
    /// (q - 1/q) / 1.5 of it. turn_sd: by this measurement alone. turn_told: the same in all points.
    double turn_sd = 0, turn_told = 0;
    double phases_per_period = 0;  // frames of one view in a period; 0: not known
    reduction::Cycle cycle{};      // empty: not measured
    double kink_frames = 1;        // v of the cycle may be wrong this close to a kink, frames
    std::vector<reduction::StickInterval> stick{};

    /// Sets base and base_sd of this harmonic. Harmonic 2 also sets turn_sd; call it after harmonic 1. False
    /// when nothing was set: no amplitude, or q outside 1 to max_harmonics.
    bool take(const reduction::MeasuredHarmonic& h);
};

/// Standard error of phi by the noise of harmonics 1 and 2, rad.
double phase_noise(const Point& p) noexcept;

/// kink_frames where v is smoothed: a quartic over 7 frames, and interpolation.
inline constexpr double smoothed_frames = 4.5;
/// Views of the walker, where their number is not known.
inline constexpr double most_views = 2;
/// The point of one measurement: without number, partner, time and place.
Point point_of(const reduction::Reduction& result, const Drive& asked);
/// Adds a measurement, with the next number, as the mirror partner of the oldest point that has none. False,
/// and it is not added, without a finite v_D or the base.
bool add_paired(std::vector<Point>& points, Point p);

/// gamma/omega, m/s: the scale of velocities at the set-point.
inline double velocity_scale(const Point& p) noexcept { return p.asked.gamma / (two_pi * p.asked.frequency); }

/// Friction, gravity and the bench in the law. mu_s = mu_k = mu.
struct Coulomb {
    double mu = 0.113;
    double tilt = 0;     // rad, positive: downhill towards +x
    double push = 0;     // r = m / M_eff: mass of the walker over the mass that its friction moves
    double drag = 0;     // s: harmonic q of the push is -(r + i s/q) a_w,q where the base is damped
    double g = paper_g;  // local gravity, m/s^2
};

/// A point with its mirror image taken: the walker on a level base drifts by -v_D at phi + pi.
struct Folded {
    const Point* point = nullptr;
    double x = 0;        // phi (rad) or gamma (m/s^2)
    double v_D = 0;      // m/s
    double sigma = 0;    // of v_D, m/s
    double x_sigma = 0;  // of x
};

/// Biharmonic points at rho = 1/2 and at the frequency that most of these have, for each gamma (m/s^2); `x`
/// is the measured phi in [0, pi), with -v_D for points at phi >= pi.
std::map<double, std::vector<Folded>> by_gamma(std::span<const Point> points);
/// The same for each asked phi modulo pi (rad, rounded to 1e-6); `x` is the measured gamma, increasing.
std::map<double, std::vector<Folded>> by_phi(std::span<const Point> points);

/// Means of neighbours whose x differ by at most same + share * x; x increases.
std::vector<Folded> merged(const std::vector<Folded>& group, double same, double share = 0);

/// "1.5 g"; g is the unit of 9.8 m/s^2.
std::string in_g(double gamma);

}  // namespace shaker::law
