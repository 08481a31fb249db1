#pragma once
// The friction coefficient for the prediction of walks: that of the plan at first, then a fit to the points.
#include <vector>

#include "calibration/estimate.hpp"
#include "daemon/campaign/travel.hpp"

namespace shaker::campaign {

/// For predictions only: mu is fitted to v_D at the asked drives by the exact Coulomb law, where each point
/// may miss the law by half a percent of the base's rms velocity, and the mu of the plan counts as known to
/// 20 %. Thread safety: one thread.
class LearnedMu {
public:
    /// g in m/s^2.
    LearnedMu(double planned, double g, int settle_at_most);

    /// A measured point.
    void add(const Drive& drive, const calibration::Estimate& v_D);
    /// The walk at the present mu.
    const Walk& walk(const Drive& drive) { return at_mu_.at(drive); }
    /// The mu of the predictions. It follows the points in steps of at least 1 %.
    [[nodiscard]] double value() const noexcept { return mu_; }

private:
    struct Measured {
        Drive drive;
        calibration::Estimate v_D;
    };
    void count(const Measured& point);
    void move_to(double mu);

    double planned_, g_;
    int settle_at_most_;
    double mu_;
    WalkPredictor at_mu_, above_;  // the second for the derivative
    std::vector<Measured> points_;
    double information_ = 0, pull_ = 0;  // of the points, about mu_
};

}  // namespace shaker::campaign
