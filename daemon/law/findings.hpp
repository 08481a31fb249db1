#pragma once
// All fits of one or several campaigns, as text and as JSON; error budgets of mu, and v_D on the asked drive.
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "daemon/law/coulomb_fit.hpp"
#include "daemon/law/phase_fits.hpp"
#include "daemon/law/slope_mu.hpp"
#include "daemon/law/verdict.hpp"

namespace shaker::law {

/// Standard uncertainties of the inputs that no scatter shows. The defaults are estimates for a bench as in
/// WIRING.md, not measurements: replace them by those of the bench's calibration.
struct InputErrors {
    /// Accelerometer's scale along the axis, relative: tumble calibration of a MEMS sensor.
    double gain = 1e-3;
    double scale = 5e-4;    // camera's scale, relative: a printed board
    double tilt = 5e-4;     // rad, where the tilt is not fitted: a machinist's level
    double clock = 2e-5;    // rate of master time, relative: a quartz
    double gravity = 2e-4;  // local g, relative: 9.8 m/s^2 from latitude and height to 2 mm/s^2
};

struct Share {
    std::string source;  // statistics, gain, scale, tilt, harmonics, corner, clock, local g
    double share = 0;    // relative standard uncertainty of mu by this source
    std::string input;   // uncertainty behind it, for people
};

struct Budget {
    std::string of;               // name of the fit
    std::vector<Share> shares{};  // largest first
    double value = NAN;           // mu
    double total = 0;             // root of the sum of squares, relative
};

/// mu_ac: by the weights of the fit. statistics: errors of v_D. harmonics: errors of the measured harmonics
/// and of the push. tilt: what the fitted tilt adds, or tilt's own error where it is not fitted. An error of
/// the clock acts on v_D and on the frequency.
Budget coulomb_budget(std::span<const Point> points, const CoulombFit& fit, const InputErrors& errors);
/// mu_k = a/g of slips: proportional to the camera's scale, to 1/T^2 and to 1/g; free of the accelerometer.
Budget slope_budget(const SlopeFit& fit, const InputErrors& errors);
/// mu_ns: proportional to gamma/g at given nulls; free of the camera's scale and of the clock. nulls: those
/// of the fit.
Budget no_stick_budget(const Fit& fit, std::span<const Fit> nulls, const InputErrors& errors);

/// v_D on the asked drive: the measured v_D, corrected by the law for what the base did else.
/// v_D = measured + law(asked, level, no push) - law(measured base, with all harmonics, push and tilt). It
/// stands beside the plain value, never instead; no fit and no guard uses it.
struct AskedDrive {
    calibration::Estimate v_D{};  // m/s; NaN: not given
    double correction = NAN;      // m/s, also when it is refused
    double model_error = NAN;     // part of v_D's error: of the law by mu, tilt and measured harmonics, m/s
    std::string reason{};         // not given; empty when given
};

/// Largest correction, as a share of gamma/omega, and largest distance of the measured v_D from the law at
/// the measured base, in errors of both.
inline constexpr double largest_correction = 0.05, farthest_from_law = 4;

/// Not given where mu is not known, where the correction is larger than 5 % of gamma/omega, or where the law
/// misses the measured v_D by more than four errors. at: of the point, from the fit.
AskedDrive on_asked_drive(const Point& point, const LawPoint& at, const CoulombFit& fit);

struct Findings {
    std::vector<Point> points;
    double gravity = paper_g;  // m/s^2, of the fits
    CoulombFit coulomb;        // mu_ac, tilt, push
    /// Mean tilt of the points by gravity, rad. The note names what a disagreement with the fitted one can
    /// be.
    Fit gravity_tilt;
    SlopeFit slopes;  // mu_k
    Fit no_stick;     // mu_ns
    std::vector<CosineFit> cosines;
    std::vector<Fit> nulls, reversals, thresholds;
    std::vector<Budget> budgets;    // of mu_ac, mu_k, mu_ns
    std::vector<AskedDrive> asked;  // in the order of the points
    /// Friction by the velocity of slip; the tilt by gravity, else by mirror partners, else without both.
    Friction friction;
    std::optional<Verdict> verdict;  // only where it was asked for
};

/// Every fit. A fit that cannot be made has the reason in its note. 228 points take about 2 s. Where all
/// points have a true v_D, null phases and reversals have their truth.
Findings analyse(std::vector<Point> points, const CoulombOptions& options = {},
                 const InputErrors& errors = {});

/// Which law describes the points.
Verdict judge(const Findings& findings, bool free_tilt);

/// The verdict's sentence; a table of the fits, the budgets and the sentences, equal ones once with their
/// places; ends with a newline.
std::string findings_text(const Findings& findings);
/// Friction by velocity as a table; an empty text without any.
std::string friction_text(const Friction& friction);
/// [{"v_R_mps", "mu", "mu_error", "pieces"}], and {"rad", "error", "from"} of its tilt.
nlohmann::ordered_json friction_json(const Friction& friction);
nlohmann::ordered_json friction_tilt_json(const Friction& friction);
/// {"gravity_mps2": ..., "fits": [{name, value, error, truth, unit, chi2, freedom, points, note, refused,
/// gamma_mps2, phi_rad, series}], "covariances": [{names, matrix}], "budgets": {"mu_ac": [{source, share,
/// input}], ...}, "law": {beyond_3, beyond_3_without_push, chi2_without_push}, "points": [{campaign, point,
/// v_D_mps, law_v_D_mps, z, doubt, asked_drive: {v_D_mps, v_D_se_mps, correction_mps, model_se_mps,
/// reason}}], "friction" and "friction_tilt": as of friction_json(), "verdict": as of verdict_json()}. Values
/// that do not exist are null.
std::string findings_json(const Findings& findings);

}  // namespace shaker::law
