#include "tracking/outline_follower.hpp"

#include <utility>

namespace shaker::tracking {

namespace {

constexpr int watched_every = 16;    // pictures
constexpr double other_blur = 0.04;  // share of the tabulated blur
constexpr double other_size = 0.05;  // px
// The roughness may exceed the watched one by this share and by so many standard errors, or by what
// rounding of grey levels makes of it (share of the contrast).
constexpr double excess = 0.02, errors = 4, rounding = 3e-3;
constexpr double more_misfit = 0.05;   // share of the blocks, beyond the watched one
constexpr double other_misfit = 0.25;  // the same, beyond that of the careful fit: it used other edges
constexpr double agreement = 2;        // standard errors of the careful fit, along the shaker's axis
constexpr double agreement_across = 4;
// Light that slopes makes one side of a small target brighter than its ground does, which moves its place by
// this share of size^2 * slope: measured at radii of 5 and 6 px.
constexpr double light_moves = 0.2;

}  // namespace

bool judge(const EdgeFitResult& fit, const OutlineReference& reference, const std::array<double, 2>& along,
           Candidate& out) {
    if (!fit.converged) return false;
    const auto& [x, y, size, blur] = fit.outline;
    const Outline& learned = reference.outline;
    const double contrast = reference.sign * fit.contrast;
    const double share = std::min(1.0, fit.coverage / reference.coverage);
    const double misfit = std::max(0.0, fit.trimmed - reference.trimmed);
    // Noise that stays while the light fades is accepted; a larger misfit is another object.
    const double roughest = std::clamp(3 * reference.noise / reference.contrast, 0.12, 0.35);
    const Eigen::Vector2d axis{along[0], along[1]};
    const Eigen::Vector2d tilt{fit.slope[0] - reference.slope[0], fit.slope[1] - reference.slope[1]};
    const double by_light = light_moves * size * size * axis.dot(tilt);
    const double sd = std::hypot(std::sqrt(axis.dot(fit.covariance * axis)), by_light, fit.bent);
    const bool good = contrast > 0.35 * reference.contrast && contrast < 3 * reference.contrast &&
                      share > 0.25 && misfit < 0.35 && fit.noise < roughest * contrast && sd < 0.5 &&
                      std::abs(size - learned.size) < std::max(0.8, 0.06 * learned.size) &&
                      blur < 2.5 * learned.blur + 0.5;
    if (!good) return false;
    out.at = {x, y};
    out.sd = sd;
    out.likeness = share * (1 - misfit);
    out.degraded = fit.bent > 0 || share < 0.75 || misfit > 0.12 || blur > 1.4 * learned.blur + 0.2;
    return true;
}

bool rougher(const EdgeFitResult& fit, const OutlineReference& reference, double times) noexcept {
    const double smooth = times * reference.noise;
    return fit.noise > smooth && fit.noise * reference.contrast > smooth * reference.sign * fit.contrast;
}

void OutlineFollower::begin(const OutlineBank::Shape& shape, Sites sites, const std::vector<Point>& shifts) {
    bank_.shape(shape, std::move(sites), shifts);
    trusted_ = followed_ = false;
    picture_ = shape.straight ? watched_every / 2 : 0;
}

bool OutlineFollower::due() const noexcept { return followed_ && picture_ == 0; }

bool OutlineFollower::follow(const ImageView& image, Point predicted, const OutlineReference& reference,
                             const std::array<double, 2>& along, std::span<KnownSlope> slopes,
                             Candidate& out) {
    picture_ = (picture_ + 1) % watched_every;
    own_ = bank_.fit(image, predicted, slopes);
    start_ = own_.converged ? Point{own_.outline.x, own_.outline.y} : predicted;
    followed_ = false;
    if (!trusted_) return false;
    EdgeFitResult fit = own_;
    const double misfit = fit.trimmed - own_misfit_;
    fit.trimmed = std::max(0.0, watched_misfit_ + misfit);
    fit.coverage *= coverage_ratio_;
    // Both, the watched roughness and this one, are known to 1 / sqrt(2 freedom).
    const double roughest = 1 + excess + errors / std::sqrt(fit.freedom);
    followed_ = judge(fit, reference, along, out) && !out.degraded && misfit < more_misfit &&
                fit.noise < std::hypot(roughest * roughness_, rounding) * std::abs(fit.contrast);
    if (followed_) bank_.accept(slopes);
    return followed_;
}

void OutlineFollower::watch(const ImageView& image, const EdgeFitResult& fit,
                            const std::array<double, 2>& along, double size, double blur,
                            std::span<KnownSlope> slopes) {
    const Point at{fit.outline.x, fit.outline.y};
    if (std::abs(blur / bank_.blur() - 1) > other_blur || std::abs(size - bank_.size()) > other_size) {
        bank_.resize(size, blur);
        own_.converged = false;
    }
    if (!own_.converged) own_ = bank_.fit(image, at, slopes);
    const Eigen::Vector2d axis{along[0], along[1]}, side{-along[1], along[0]};
    const Eigen::Vector2d apart{own_.outline.x - at.x, own_.outline.y - at.y};
    const auto in_errors = [&](const Eigen::Vector2d& direction) {
        return std::abs(direction.dot(apart)) / std::sqrt(direction.dot(fit.covariance * direction));
    };
    trusted_ = fit.converged && own_.converged && own_.trimmed < fit.trimmed + other_misfit &&
               in_errors(axis) < agreement && in_errors(side) < agreement_across;
    if (!trusted_) return;
    if (!followed_) bank_.accept(slopes);
    bank_.learn_response(image, slopes);
    roughness_ = own_.noise / std::abs(own_.contrast);
    own_misfit_ = own_.trimmed;
    watched_misfit_ = fit.trimmed;
    coverage_ratio_ = fit.coverage / own_.coverage;
}

}  // namespace shaker::tracking
