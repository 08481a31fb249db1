#include "daemon/campaign/campaign_mu.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "drivers/errors.hpp"
#include "drivers/walker/no_stick.hpp"

namespace shaker::campaign {

namespace {

constexpr double planned_share = 0.2;  // error of the mu of the plan
constexpr double law_share = 0.005;    // of the base's rms velocity, by which a point may miss the law
constexpr double difference = 0.01;    // of mu, for the derivative
constexpr double least_change = 0.01;  // of mu
constexpr double most_change = 0.3;    // of mu, in one step: the law is not linear
constexpr std::size_t to_judge = 12;   // passes, from which other laws are distinguished
constexpr double level = 5e-3;         // rad, error of a tilt that is not measured

// The numbers of a schedule are those of its order.
std::size_t index_of(const std::vector<Point>& points, int id) {
    const auto i = static_cast<std::size_t>(id - 1);
    if (i < points.size() && points[i].id == id) return i;
    return static_cast<std::size_t>(std::ranges::find(points, id, &Point::id) - points.begin());
}

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
    points_.push_back({drive, {}, {}, v_D});
    count(points_.back());
    const double prior = 1 / (planned_share * planned_ * planned_share * planned_);
    const double step = (pull_ + prior * (planned_ - mu_)) / (information_ + prior);
    if (std::abs(step) >= least_change * mu_)
        move_to(mu_ + std::clamp(step, -most_change * mu_, most_change * mu_));
}

Walk LearnedMu::walk(const Drive& drive) {
    Walk walk = at_mu_.at(drive);
    const auto measured = run::measured_walk(drive, points_);
    if (!measured) return walk;
    walk.v_D = measured->v_D.value;
    if (!walk.why.empty()) walk = {walk.v_D, settle_at_most_};
    return walk;
}

run::PredictedWalk LearnedMu::prediction(const Drive& drive) {
    if (auto measured = run::measured_walk(drive, points_)) return *measured;
    return {{at_mu_.at(drive).v_D, run::unknown_error(drive)},
            fmt::format("Coulomb's law with mu {:.4g}", mu_)};
}

void LearnedMu::count(const reduction::DrivenPoint& point) {
    const Walk& here = at_mu_.at(point.asked);
    const Walk& above = above_.at(point.asked);
    if (!here.why.empty() || !above.why.empty()) return;
    const double slope = (above.v_D - here.v_D) / (difference * mu_);
    const double error =
        std::hypot(point.v_D.sigma, law_share * walker::v_rms(harmonics(point.asked), point.asked.frequency));
    information_ += slope * slope / (error * error);
    pull_ += slope * (point.v_D.value - here.v_D) / (error * error);
}

void LearnedMu::move_to(double mu) {
    mu_ = mu;
    at_mu_ = WalkPredictor{mu, g_, settle_at_most_};
    above_ = WalkPredictor{mu * (1 + difference), g_, settle_at_most_};
    information_ = pull_ = 0;
    for (const reduction::DrivenPoint& point : points_) count(point);
}

MuChoice::MuChoice(double target, double planned, double g)
    : target_{target}, planned_{planned}, law_{.mu = planned, .g = g} {}

void MuChoice::add(law::Point pass) {
    if (!std::isfinite(pass.v_D.value) || !(pass.v_D.sigma > 0)) return;
    pass.cycle = {};  // the fit does not need it, and there may be thousands of passes
    passes_.push_back(std::move(pass));
    changed_ = true;
}

void MuChoice::forget(int point) {
    changed_ |= std::erase_if(passes_, [&](const law::Point& p) { return p.number == point; }) > 0;
}

void MuChoice::Information::add(const law::LawPoint& slopes, double variance) noexcept {
    mu += slopes.by_mu * slopes.by_mu / variance;
    tilt += slopes.by_tilt * slopes.by_tilt / variance;
    both += slopes.by_mu * slopes.by_tilt / variance;
}

// The law at a drive; no slopes where the motion does not settle.
law::LawPoint MuChoice::at(const Drive& drive) const try {
    law::Point point;
    point.base = harmonics(drive);
    point.frequency = drive.frequency;
    return law_point(point, law_);
} catch (const InputError&) {
    return {};
}

// What measuring the point will add.
void MuChoice::add_expected(const Point& point, Information& to) const {
    const PointSettings& asked = point.asked;
    const int periods = asked.precision > 0 ? asked.most_periods : asked.plan.periods;
    const double sigma = std::hypot(noise_ / std::sqrt(std::max(periods, 1)),
                                    base_share_ * asked.drive.gamma / (two_pi * asked.drive.frequency));
    to.add(at(asked.drive), sigma * sigma);
}

// mu, tilt and what the passes have shown of the errors.
void MuChoice::fit(bool partners) {
    if (!std::exchange(changed_, false)) return;
    const double mu_error = planned_share * planned_;
    known_ = {.mu = 1 / (mu_error * mu_error), .tilt = 1 / (level * level)};
    reached_ = refused_ = false;
    const law::CoulombFit found =
        law::fit_coulomb(passes_, {.g = law_.g, .start_mu = std::isfinite(mu_error_) ? law_.mu : NAN});
    why_ = found.known() && partners && !std::isfinite(found.tilt.value) ? found.tilt.note : found.mu.note;
    double noise = 0, base = 0;
    for (std::size_t i = 0; i < passes_.size(); ++i) {
        const law::Point& p = passes_[i];
        const double base_error = found.known() ? found.points[i].base_error : 0;
        const double variance = p.v_D.sigma * p.v_D.sigma + base_error * base_error;
        known_.add(found.known() ? found.points[i] : at(p.asked), variance);
        noise += p.v_D.sigma * p.v_D.sigma * std::max(p.periods, 1) / static_cast<double>(passes_.size());
        base += std::pow(base_error / velocity_scale(p), 2) / static_cast<double>(passes_.size());
    }
    if (!passes_.empty()) noise_ = std::sqrt(noise), base_share_ = std::sqrt(base);
    if (!found.known()) return;
    law_.mu = found.mu.value;
    law_.tilt = found.law.tilt;
    const double spread = found.mu.freedom > 0 ? found.mu.chi2 / found.mu.freedom : 1;
    mu_error_ = found.mu.refused ? NAN : found.mu.error * std::sqrt(std::max(1.0, spread));
    const bool both = !partners || std::isfinite(found.tilt.value);
    reached_ = mu_error_ <= target_ * law_.mu && both;
    refused_ = found.mu.refused && found.mu.error <= target_ * law_.mu && both && passes_.size() >= to_judge;
}

std::size_t MuChoice::next(const std::vector<Point>& points, const std::vector<bool>& over,
                           const Cost& cost) {
    // A pair is completed first.
    for (std::size_t i = 0; i < points.size(); ++i)
        if (const int partner = points[i].partner;
            !over[i] && partner != 0 && over[index_of(points, partner)])
            return i;
    fit(std::ranges::any_of(points, [](const Point& p) { return p.partner != 0; }));
    if (reached_ || refused_) return points.size();
    std::size_t best = points.size();
    double most = -1;
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (over[i]) continue;
        std::vector<const Point*> together{&points[i]};
        if (points[i].partner != 0) together.push_back(&points[index_of(points, points[i].partner)]);
        Information then = known_;
        for (const Point* p : together) add_expected(*p, then);
        // One that cannot be measured fails by name when its turn comes: at the end.
        const double gain = std::log(known_.variance_of_mu() / then.variance_of_mu()) / cost(together);
        if (gain > most) most = gain, best = i;
    }
    return best;
}

std::string MuChoice::sentence() const {
    if (!std::isfinite(mu_error_)) return "mu is not known: " + why_;
    return fmt::format("mu {:.5f} +- {:.5f} ({:.2g} %, target {:.2g} %) from {} passes", law_.mu, mu_error_,
                       100 * mu_error_ / law_.mu, 100 * target_, passes_.size());
}

}  // namespace shaker::campaign
