#pragma once
// All fits of one or several campaigns, as text and as JSON.
#include <span>
#include <string>
#include <vector>

#include "daemon/law/asked_drive.hpp"
#include "daemon/law/budget.hpp"
#include "daemon/law/phase_fits.hpp"

namespace shaker::law {

struct Findings {
    std::vector<Point> points;
    CoulombFit coulomb;  // mu_ac, tilt, push
    SlopeFit slopes;     // mu_k
    Fit no_stick;        // mu_ns
    std::vector<CosineFit> cosines;
    std::vector<Fit> nulls, reversals, thresholds;
    std::vector<Budget> budgets;    // of mu_ac, mu_k, mu_ns
    std::vector<AskedDrive> asked;  // in the order of the points
};

/// Every fit. A fit that cannot be made has the reason in its note. 228 points take about 2 s. Where all
/// points have a true v_D, mu_ns, v_D*, Theta*, null phases and reversals have their truth.
Findings analyse(std::vector<Point> points, const CoulombOptions& options = {},
                 const InputErrors& errors = {});

/// A table of the fits, the budgets and the sentences; ends with a newline.
std::string findings_text(const Findings& findings);
/// {"fits": [{name, value, error, truth, unit, chi2, freedom, points, note, gamma_mps2, phi_rad, series}],
/// "covariances": [{names, matrix}], "budgets": {"mu_ac": [{source, share, input}], ...}, "law": {beyond_3,
/// beyond_3_without_push, chi2_without_push}, "points": [{campaign, point, v_D_mps, law_v_D_mps, z,
/// asked_drive: {v_D_mps, v_D_se_mps, correction_mps, model_se_mps, reason}}]}. Values that do not exist are
/// null.
std::string findings_json(const Findings& findings);

}  // namespace shaker::law
