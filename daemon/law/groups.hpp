#pragma once
// Points sorted into groups with the same drive but for one quantity.
#include <map>
#include <span>
#include <tuple>
#include <vector>

#include "daemon/law/point.hpp"

namespace shaker::law {

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

/// "1.5 g"; g is the unit of 9.8 m/s^2.
std::string in_g(double gamma);

}  // namespace shaker::law
