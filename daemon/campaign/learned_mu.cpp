#include "daemon/campaign/learned_mu.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/walker/no_stick.hpp"

namespace shaker::campaign {

namespace {
constexpr double planned_share = 0.2;  // error of the mu of the plan
constexpr double law_share = 0.005;    // of the base's rms velocity, by which a point may miss the law
constexpr double difference = 0.01;    // of mu, for the derivative
constexpr double least_change = 0.01;  // of mu
constexpr double most_change = 0.3;    // of mu, in one step: the law is not linear
}  // namespace

LearnedMu::LearnedMu(double planned, double g, int settle_at_most)
    : planned_{planned},
      g_{g},
      settle_at_most_{settle_at_most},
      mu_{planned},
      at_mu_{planned, g, settle_at_most},
      above_{planned * (1 + difference), g, settle_at_most} {}

void LearnedMu::add(const Drive& drive, const calibration::Estimate& v_D) {
    if (!std::isfinite(v_D.value) || !std::isfinite(v_D.sigma)) return;
    points_.push_back({drive, v_D});
    count(points_.back());
    const double prior = 1 / (planned_share * planned_ * planned_share * planned_);
    const double step = (pull_ + prior * (planned_ - mu_)) / (information_ + prior);
    if (std::abs(step) >= least_change * mu_)
        move_to(mu_ + std::clamp(step, -most_change * mu_, most_change * mu_));
}

void LearnedMu::count(const Measured& point) {
    const Walk& here = at_mu_.at(point.drive);
    const Walk& above = above_.at(point.drive);
    if (!here.why.empty() || !above.why.empty()) return;
    const double slope = (above.v_D - here.v_D) / (difference * mu_);
    const double error =
        std::hypot(point.v_D.sigma, law_share * walker::v_rms(harmonics(point.drive), point.drive.frequency));
    information_ += slope * slope / (error * error);
    pull_ += slope * (point.v_D.value - here.v_D) / (error * error);
}

void LearnedMu::move_to(double mu) {
    mu_ = mu;
    at_mu_ = WalkPredictor{mu, g_, settle_at_most_};
    above_ = WalkPredictor{mu * (1 + difference), g_, settle_at_most_};
    information_ = pull_ = 0;
    for (const Measured& point : points_) count(point);
}

}  // namespace shaker::campaign
