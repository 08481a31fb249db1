#pragma once
// The friction coefficient of walker and base during a campaign: for the prediction of walks, that of the
// plan at first, then a fit to the points; and the shortest way to it: which set-point of a plan comes next,
// and when mu is known.
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "calibration/estimate.hpp"
#include "daemon/campaign/plan.hpp"
#include "daemon/campaign/travel.hpp"
#include "daemon/law/coulomb_fit.hpp"
#include "daemon/run/walk_prediction.hpp"

namespace shaker::campaign {

/// For predictions only: mu is fitted to v_D at the asked drives by the exact Coulomb law, where each point
/// may miss the law by half a percent of the base's rms velocity, and the mu of the plan counts as known to
/// 20 %. At a drive that was measured, or its mirror image, the walk is the measured one, whatever the law.
/// Thread safety: one thread.
class LearnedMu {
public:
    /// g in m/s^2.
    LearnedMu(double planned, double g, int settle_at_most);

    /// A measured point.
    void add(const Drive& drive, const calibration::Estimate& v_D);
    /// The walk as measured, else at the present mu.
    Walk walk(const Drive& drive);
    /// The same with its error and its source.
    run::PredictedWalk prediction(const Drive& drive);
    /// The mu of the predictions. It follows the points in steps of at least 1 %.
    [[nodiscard]] double value() const noexcept { return mu_; }

private:
    void count(const reduction::DrivenPoint& point);
    void move_to(double mu);

    double planned_, g_;
    int settle_at_most_;
    double mu_;
    WalkPredictor at_mu_, above_;  // the second for the derivative
    std::vector<reduction::DrivenPoint> points_;
    double information_ = 0, pull_ = 0;  // of the points, about mu_
};

/// The set-points of the plan are candidates; mirror partners follow each other. The next one is that with
/// the largest decrease of ln(variance of mu) for its bench time, where each candidate adds the information
/// of its v_D on mu and tilt: the derivatives of the exact Coulomb law at the asked drive, over the error of
/// v_D that the points so far had. Thread safety: one thread.
class MuChoice {
public:
    /// Bench time of these points in this order, s; infinite when one of them cannot be measured.
    using Cost = std::function<double(std::span<const Point* const>)>;

    /// target: relative standard error of mu at which the campaign ends. planned: mu of the plan. g in m/s^2.
    MuChoice(double target, double planned, double g);

    /// A measured pass; number and partner of the point are set.
    void add(law::Point pass);
    /// The passes of this point do not count any more.
    void forget(int point);
    /// Index of the next point among those that are not over; the number of points when all are over, or mu
    /// is known. A series of mirror partners is needed for the tilt; where the plan has partners, mu is not
    /// known before the tilt.
    std::size_t next(const std::vector<Point>& points, const std::vector<bool>& over, const Cost& cost);
    /// The target is reached. Never where the passes refuse Coulomb's law: no mu of it is known then, and
    /// next() ends the campaign where the target would have been reached, after 12 passes at least.
    [[nodiscard]] bool reached() const noexcept { return reached_; }
    /// "mu 0.11302 +- 0.00018 (0.16 %, target 0.2 %) from 6 passes", or why mu is not known.
    [[nodiscard]] std::string sentence() const;

private:
    /// Information on mu and tilt: the inverse of their covariance. `both` is its element off the diagonal.
    struct Information {
        double mu = 0, tilt = 0, both = 0;
        /// A measurement with this variance, whose result changes by these slopes with mu and tilt.
        void add(const law::LawPoint& slopes, double variance) noexcept;
        [[nodiscard]] double variance_of_mu() const noexcept {
            return tilt * (1 / (mu * tilt - both * both));
        }
    };

    void fit(bool partners);
    [[nodiscard]] law::LawPoint at(const Drive& drive) const;
    void add_expected(const Point& point, Information& to) const;

    double target_, planned_;
    law::Coulomb law_;                // the newest
    double mu_error_ = NAN;           // standard error, widened by chi^2 where that is more than expected
    std::vector<law::Point> passes_;  // measured
    Information known_;               // so far
    double noise_ = 1e-5;             // error of v_D of one period, m/s sqrt(period)
    double base_share_ = 0;           // error of the law by the measured base, of gamma/omega
    bool changed_ = true, reached_ = false;
    bool refused_ = false;  // Coulomb's law, by passes that would have been enough
    std::string why_;       // mu is not known
};

}  // namespace shaker::campaign
