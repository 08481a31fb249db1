#pragma once
// Which law of friction describes the points.
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "daemon/law/law_fit.hpp"

namespace shaker::law {

/// A drive at which two laws differ most.
struct TellingDrive {
    Drive drive{};
    double apart = 0;  // difference of v_D, m/s
};

/// Each law is judged by Schwarz's criterion, chi^2 + k ln n (Ann. Stat. 6, 461, 1978), k: free parameters,
/// n: points. Its assumption: errors are normal, and every law is as likely before the measurement. chi^2 is
/// that of v_D and, where at least one law describes them, of harmonics 9 to 16 of the base.
struct Verdict {
    std::vector<LawFit> fits;   // one for each row of `laws`
    std::vector<double> score;  // of each; NaN: it has no fit
    bool harmonics = false;     // harmonics 9 to 16 were used
    /// Index of the law with the least score, of the simpler ones where they are less than `decisive` above
    /// it.
    std::optional<std::size_t> chosen;
    /// Laws less than `decisive` above the least score that do not contain the chosen one.
    std::vector<std::size_t> rivals;
    std::optional<TellingDrive> measure;  // would distinguish the first rival
    bool refused = false;                 // the data refuse also the chosen law
    std::string sentence;
    std::vector<int> points;  // numbers of the points that were judged
};

/// Difference of two scores that decides: odds of 150 to 1.
inline constexpr double decisive = 10;

/// Fits every law and chooses; 24 points take about 10 s of one core. Of more than most_judged points it
/// takes so many, evenly through the campaigns, with their mirror partners. tilt: by gravity, rad.
Verdict judge(std::span<const Point> points, const CoulombOptions& options,
              const calibration::Estimate& tilt);
inline constexpr std::size_t most_judged = 300;
/// About `most` points, evenly through the campaigns; mirror partners stay together.
std::vector<Point> evenly(std::span<const Point> points, std::size_t most);

/// One line for each law, and the sentence; ends with a newline.
std::string verdict_text(const Verdict& verdict);
/// {"chosen": name, "refused", "points": [number], "rivals": [name], "measure": {"gamma_mps2", "phi_rad",
/// "v_D_apart_mps"}, "harmonics", "sentence", "laws": [{"name", "words", "mu", "mu_error", "tilt_rad",
/// "tilt_error", "mean_place_m", "parameters": [{"name", "unit", "value", "error"}], "covariance": [of mu and
/// these, row by row], "chi2", "freedom", "chi2_base", "freedom_base", "score", "reason", "z": [...]}]}.
/// Values that do not exist are null.
nlohmann::ordered_json verdict_json(const Verdict& verdict);

}  // namespace shaker::law
