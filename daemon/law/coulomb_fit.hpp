#pragma once
// mu_ac: the exact law of Coulomb friction fitted to all points at once, each at its measured drive.
#include <span>
#include <vector>

#include "daemon/law/fit.hpp"
#include "daemon/law/sensitivity.hpp"

namespace shaker::law {

/// One point beside the law.
struct LawPoint {
    double v_D = NAN;         // law at the measured base with its push and tilt, m/s
    double base_error = NAN;  // standard error of that from the errors of the measured harmonics, m/s
    double z = NAN;           // (measured - law) / both errors
    double by_mu = 0, by_tilt = 0, by_push = 0, by_gravity = 0;  // derivatives of v_D: m/s, m/s per rad, ...
    double by_turn = 0;  // m/s per rad of phi, as an accelerometer's corner turns the harmonics
    double by_gain = 0;  // m/s for a relative change of all accelerations
    PushedCycle cycle;
};

struct CoulombOptions {
    double g = paper_g;     // local gravity, m/s^2
    double start_mu = NAN;  // near the solution; NaN: searched
    bool free_tilt = true;  // fitted when mirror partners exist; otherwise the base is level
};

struct CoulombFit {
    Fit mu, tilt, push;     // 1, rad, m/M_eff; tilt and push are NaN with the reason when they are not fitted
    Coulomb law;            // with the fitted values
    Covariance covariance;  // of mu and tilt
    std::vector<LawPoint> points;    // in the order of the input
    std::vector<double> gain;        // change of mu for a change of each point's v_D, s/m
    int beyond_3 = 0;                // points with |z| > 3
    double chi2_without_push = NAN;  // of the same law when the push is left out
    int beyond_3_without_push = 0;
    [[nodiscard]] bool known() const noexcept { return std::isfinite(mu.value); }
};

/// Weighted least squares of v_D over all points: errors of v_D and of the measured harmonics, which move the
/// law. m/M_eff comes from harmonics 9 to 16, which nothing but the push moves: P_q = -(m/M_eff) a_w,q.
/// Gauss-Newton from the best of a set of mu between 0.02 and 1. Not given, with the reason: fewer than three
/// points that move, no mu in that range that describes them, no convergence.
CoulombFit fit_coulomb(std::span<const Point> points, const CoulombOptions& options = {});

/// True for two pairs of mirror partners or more: v_D then shows the tilt.
bool shows_tilt(std::span<const Point> points);

/// The law at one point, with all derivatives. start: a nearby cycle.
LawPoint law_point(const Point& point, const Coulomb& law, const PushedCycle* start = nullptr);

}  // namespace shaker::law
