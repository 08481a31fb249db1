#pragma once
// The shortest way to a friction coefficient: which set-point of a plan comes next, and when mu is known.
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "daemon/campaign/plan.hpp"
#include "daemon/law/coulomb_fit.hpp"

namespace shaker::campaign {

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
    /// The target is reached.
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
    std::string why_;  // mu is not known
};

}  // namespace shaker::campaign
