#include "tracking/outline_locator.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace shaker::tracking {

namespace {

constexpr int watched_every = 16;    // pictures
constexpr int watched_pixels = 500;  // with which the careful fit watches the filters
constexpr double other_blur = 0.04;  // share of the tabulated blur
constexpr double other_size = 0.05;  // px
// The roughness may exceed the watched one by this share and by so many standard errors, or by what
// rounding of grey levels makes of it (share of the contrast).
constexpr double excess = 0.02, errors = 4, rounding = 3e-3;
constexpr double more_misfit = 0.05;   // share of the blocks, beyond the watched one
constexpr double other_misfit = 0.25;  // the same, beyond that of the careful fit: it used other edges
constexpr double agreement = 2;        // standard errors of the careful fit, along the shaker's axis
constexpr double agreement_across = 4;
constexpr double cut_roughness = 1.2;  // times the residuals of frame 0: cut, or of another shape
// Light that slopes makes one side of a small target brighter than its ground does, which moves its place by
// this share of size^2 * slope: measured at radii of 5 and 6 px.
constexpr double light_moves = 0.2;

// A mean of the fitted blurs that follows a lens out of focus at once.
double followed_blur(double blur, double fitted) noexcept {
    const double change = fitted - blur;
    return blur + (std::abs(change) > std::max(0.1 * blur, 0.15) ? 1 : 0.1) * change;
}

}  // namespace

OutlineLocator::OutlineLocator(Subject subject, bool straight)
    : subject_{std::move(subject)},
      sign_{subject_.target.polarity == Polarity::bright ? 1.0 : -1.0},
      along_{straight ? std::array{1.0, 0.0} : subject_.along},
      fit_{straight},
      straight_{straight} {}

void OutlineLocator::expect(const Outline& outline) noexcept {
    learned_ = outline;
    size_ = outline.size;
    blur_ = outline.blur;
}

void OutlineLocator::begin(const EdgeFitResult& fit, const Levels& levels, const std::vector<Point>& shifts,
                           int means) {
    expect(fit.outline);
    contrast_ = std::abs(fit.contrast);
    coverage_ = fit.coverage;
    noise_ = fit.noise;
    trimmed_ = fit.trimmed;
    slope_ = fit.slope;
    prior_.size = 0.02;
    prior_.blur = 0.5;
    const int pixels = static_cast<int>(fit_.samples().size());
    search_every_ = (pixels + searched_pixels - 1) / searched_pixels;
    watch_every_ = pitch() > 0 ? 1 : (pixels + watched_pixels - 1) / watched_pixels;
    bank_.shape({.size = size_,
                 .blur = blur_,
                 .size_sd = prior_.size,
                 .ground = ground(),
                 .reach = prior_.reach,
                 .level = 0.5 * (levels.low + levels.high),
                 .straight = straight_,
                 .means = means},
                sites(), shifts);
    trusted_ = followed_ = false;
    picture_ = straight_ ? watched_every / 2 : 0;
}

EdgeFitResult OutlineLocator::measure(const ImageView& image, Point start, const EdgePrior& prior,
                                      double enough, int every) {
    Point centre = start;
    constexpr int most = 14;
    for (const int passes : {straight_ ? most : 5, straight_ ? most : 6, most}) {
        gather(image, centre, every);
        if (fit_.samples().size() < 24) return {};
        EdgeFitResult fit =
            fit_.fit({centre.x, centre.y, size_, blur_}, prior, blocks_, ground(), passes, enough);
        const Point found{fit.outline.x, fit.outline.y};
        const double moved = length(found - centre);
        fit.coverage *= every;
        if (fit.converged && moved < 1) return fit;
        if (!(moved < 2 * rim()) || !(fit.noise < prior.roughest * sign_ * fit.contrast)) return {};
        centre = found;
    }
    return {};
}

bool OutlineLocator::judge(const EdgeFitResult& fit, Candidate& out) const {
    if (!fit.converged) return false;
    const auto& [x, y, size, blur] = fit.outline;
    const double contrast = sign_ * fit.contrast;
    const double share = std::min(1.0, fit.coverage / coverage_);
    const double misfit = std::max(0.0, fit.trimmed - trimmed_);
    // Noise that stays while the light fades is accepted; a larger misfit is another object.
    const double roughest = std::clamp(3 * noise_ / contrast_, 0.12, 0.35);
    const Eigen::Vector2d axis{along_[0], along_[1]};
    const Eigen::Vector2d tilt{fit.slope[0] - slope_[0], fit.slope[1] - slope_[1]};
    const double by_light = light_moves * size * size * axis.dot(tilt);
    const double sd = std::hypot(std::sqrt(axis.dot(fit.covariance * axis)), by_light, fit.bent);
    const bool good = contrast > 0.35 * contrast_ && contrast < 3 * contrast_ && share > 0.25 &&
                      misfit < 0.35 && fit.noise < roughest * contrast && sd < 0.5 &&
                      std::abs(size - learned_.size) < std::max(0.8, 0.06 * learned_.size) &&
                      blur < 2.5 * learned_.blur + 0.5;
    if (!good) return false;
    out.at = {x, y};
    out.sd = sd;
    out.likeness = share * (1 - misfit);
    out.degraded = fit.bent > 0 || share < 0.75 || misfit > 0.12 || blur > 1.4 * learned_.blur + 0.2;
    return true;
}

bool OutlineLocator::rougher(const EdgeFitResult& fit, double times) const noexcept {
    const double smooth = times * noise_;
    return fit.noise > smooth && fit.noise * contrast_ > smooth * sign_ * fit.contrast;
}

bool OutlineLocator::is_target(const EdgeFitResult& fit, Candidate& out) const {
    if (!judge(fit, out)) return false;
    out.sd *= std::sqrt(bank_.common());
    out.degraded = out.degraded || (plane() && rougher(fit, cut_roughness));
    return true;
}

bool OutlineLocator::locate(const ImageView& image, Point predicted, Candidate& out) {
    start_ = predicted;
    own_.converged = followed_ = false;
    if (look(image, predicted) && follow(predicted, out)) {
        const bool thinned = !straight_ && pitch() == 0;
        if (picture_ == 0) watch(measure(image, out.at, prior_, thinned ? coarse : precise, watch_every_));
        return true;
    }
    return find_near(image, predicted, out);
}

EdgeFitResult OutlineLocator::fit_near(const ImageView& image, Point at, Candidate& out) {
    EdgeFitResult fit = measure(image, at, prior_);
    fit.converged = is_target(fit, out);
    return fit;
}

bool OutlineLocator::try_at(const ImageView& image, Point at, Point predicted, Candidate& out) {
    const EdgeFitResult fit = fit_near(image, at, out);
    const double farthest = reach() + (pitch() > 0 ? 0 : rim());
    if (!fit.converged || length(out.at - predicted) > farthest) return false;
    if (!straight_ || !out.degraded) fit_.accept();
    watch(fit);
    return true;
}

void OutlineLocator::filter(Point at) {
    own_ = bank_.fit(seen_, at - origin_, fit_.slopes());
    own_.outline.x += origin_.x;
    own_.outline.y += origin_.y;
}

bool OutlineLocator::follow(Point predicted, Candidate& out) {
    picture_ = (picture_ + 1) % watched_every;
    filter(predicted);
    if (own_.converged) start_ = {own_.outline.x, own_.outline.y};
    if (!trusted_) return false;
    EdgeFitResult fit = own_;
    const double misfit = fit.trimmed - own_misfit_;
    fit.trimmed = std::max(0.0, watched_misfit_ + misfit);
    fit.coverage *= coverage_ratio_;
    // Both, the watched roughness and this one, are known to 1 / sqrt(2 freedom).
    const double roughest = 1 + excess + errors / std::sqrt(fit.freedom);
    followed_ = judge(fit, out) && !out.degraded && misfit < more_misfit &&
                fit.noise < std::hypot(roughest * roughness_, rounding) * std::abs(fit.contrast);
    if (followed_) bank_.accept(fit_.slopes());
    return followed_;
}

// The careful fit of a picture that follow() left to it, or that was due. Where the filters disagree with it,
// it decides the next picture.
void OutlineLocator::watch(EdgeFitResult fit) {
    const auto& [x, y, size, blur] = fit.outline;
    if (fit.converged) {
        blur_ = followed_blur(blur_, blur);
        size_ += std::clamp(0.2 * (size - size_), -most_growth_, most_growth_);
    }
    if (std::abs(blur_ / bank_.blur() - 1) > other_blur || std::abs(size_ - bank_.size()) > other_size) {
        bank_.resize(size_, blur_);
        own_.converged = false;
    }
    if (!own_.converged) filter({x, y});
    const Eigen::Vector2d axis{along_[0], along_[1]}, side{-along_[1], along_[0]};
    const Eigen::Vector2d apart{own_.outline.x - x, own_.outline.y - y};
    const auto in_errors = [&](const Eigen::Vector2d& direction) {
        return std::abs(direction.dot(apart)) / std::sqrt(direction.dot(fit.covariance * direction));
    };
    trusted_ = fit.converged && own_.converged && own_.trimmed < fit.trimmed + other_misfit &&
               in_errors(axis) < agreement && in_errors(side) < agreement_across;
    if (!trusted_) return;
    if (!followed_) bank_.accept(fit_.slopes());
    bank_.learn_response(seen_, fit_.slopes());
    roughness_ = own_.noise / std::abs(own_.contrast);
    own_misfit_ = own_.trimmed;
    watched_misfit_ = fit.trimmed;
    coverage_ratio_ = fit.coverage / own_.coverage;
}

}  // namespace shaker::tracking
