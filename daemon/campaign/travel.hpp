#pragma once
// Where the walker goes at a point: predicted drift, whether the point fits into the view, and in how many
// passes.
#include <map>
#include <string>
#include <vector>

#include "daemon/campaign/plan.hpp"

namespace shaker::campaign {

inline constexpr int least_pass_periods = 5;  // measured in one pass

/// Part of the view that the walker's middle may use, m. A pass ends `margin` before the limit at the edge.
struct FreeWay {
    double view = 0;     // length of the view along the shaker's axis
    double walker = 0;   // diameter
    double edge = 5e-3;  // limit: least distance of the outline from the end of the view
    double margin = 2e-3;
    [[nodiscard]] double length() const noexcept { return view - walker - 2 * (edge + margin); }
};

/// What the runner needs around a measurement. Periods of the drive where not stated.
struct Timing {
    int ramp = 1;                   // of a change of the set-point; one at each end of a pass
    int drive_settles = 25;         // from the end of the ramp until the drive has been found at its target
    int settle_at_most = 400;       // then the measurement starts anyway
    double result_s = 0.35;         // from the last period to the next set-point
    double runs_on = 3;             // from the order of another drive until it is in force
    double kept = 5;                // of way at the edge, that no pass is planned to use
    double least = 4;               // of way that is left: the pass ends. runs_on, and a period for the place
    double return_mps = 0.035;      // velocity of a return
    double return_s = 1.0;          // ramps and settling of a return
    double recording_s = INFINITY;  // that one recording can hold; a pass is measured in one
    int starts = 150;               // from rest to the set-point: identification, loop check, soft start
    double start_s = 3;             // besides
    /// m/s^2, by the frequency: what the limits of the bench allow the drives of a return. One that is
    /// missing is not limited.
    std::map<double, double> most_return_gamma{};
};

/// All parameters of a drive. Drives with equal numbers are equal.
std::vector<double> numbers_of(const Drive& drive);

/// The settled motion at one drive by the exact Coulomb law.
struct Walk {
    double v_D = 0;     // m/s
    int settling = 0;   // periods from rest until the runner's rule finds the drift steady, limited
    std::string why{};  // there is no settled motion; empty when there is
};

/// Predicts walks at a friction coefficient, each drive once. mu_s = mu_k = mu, level base; g in m/s^2.
class WalkPredictor {
public:
    explicit WalkPredictor(double mu, double g = paper_g, int settle_at_most = Timing{}.settle_at_most);
    const Walk& at(const Drive& drive);

private:
    double mu_, g_;
    int settle_at_most_;
    std::map<std::vector<double>, Walk> known_;
};

/// The travel of one point.
struct Travel {
    double v_D = 0;        // m/s
    double period_s = 0;   // of the drive
    int settling = 0;      // periods before each pass
    int periods = 0;       // measured in each pass, the last one at most this many
    int passes = 0;        // 0: the point does not fit
    int last_periods = 0;  // measured in the last pass
    double way = 0;        // of a pass, m, positive: ramps, settling, measuring
    std::string why{};     // it does not fit and what would help; empty when it fits
    [[nodiscard]] bool fits() const noexcept { return passes > 0; }
    /// Longest pass with its ramps and settling, s.
    [[nodiscard]] double drive_s() const noexcept { return (settling + 2 + periods) * period_s; }
    /// In all passes.
    [[nodiscard]] int measured() const noexcept { return fits() ? (passes - 1) * periods + last_periods : 0; }
};

/// The drives that lead the walker back: phi 0 or pi, the largest gamma of the points of this frequency and
/// at least 1 g, as far as the limits of the bench allow.
class ReturnDrives {
public:
    ReturnDrives(const std::vector<Point>& points, const Timing& timing);
    /// direction: of the walk, +1 or -1.
    [[nodiscard]] Drive at(int direction, double frequency) const;

private:
    std::map<double, double> gamma_;  // m/s^2, by the frequency
};

/// What no pass of this walk is planned to use, m: a reserve at the edge, and a period of the way back, whose
/// walk is `back`.
double kept_way(const Walk& walk, const Walk& back, const Timing& timing, double frequency);

/// The rule: a point does not fit when the free way is less than |v_D| (settling + 5 T) + ramps. With less
/// than it needs for all periods, or with less than it needs left of a recording, it is measured in passes of
/// equal length, at least 5 periods each. With a precision: the most periods. free_way in m.
Travel travel(const PointSettings& point, const Walk& walk, const Timing& timing, double free_way);

/// One predicted point of a campaign: the walker's places (m from the middle of the view) and the bench's
/// time, s.
struct Stage {
    double begin = 0, end = 0;
    double returned = 0;  // way of all returns, m
    double settling_s = 0, measuring_s = 0, returning_s = 0, other_s = 0;
    [[nodiscard]] double bench_s() const noexcept { return settling_s + measuring_s + returning_s + other_s; }
};

/// Where a walker that can be put anywhere should begin a point: the middle of its pass is that of the view.
/// m from there.
double best_start(const Travel& travel);

/// Leads a predicted walker from `place` through a point and changes `place`: a return before the point if it
/// does not fit into what is left, so that the middle of the pass is that of the view, and one before each
/// further pass. A point that does not fit takes no time.
Stage lead(const Travel& travel, const Timing& timing, double free_way, double& place);

}  // namespace shaker::campaign
