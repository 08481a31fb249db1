#include "tracking/outline_follower.hpp"

#include <cmath>
#include <utility>

namespace shaker::tracking {
namespace {

constexpr int watched_every = 16;                  // pictures
constexpr double other_blur = 0.04;                // share of the tabulated blur
constexpr double rougher = 1.25, rounding = 3e-3;  // times the watched roughness; of the contrast
constexpr double most_misfit = 0.05;               // share of the blocks

}  // namespace

void OutlineFollower::begin(const OutlineBank::Shape& shape, Sites sites, const std::vector<Point>& shifts) {
    bank_.shape(shape, std::move(sites), shifts);
    until_watched_ = 0;
}

bool OutlineFollower::follow(const ImageView& image, Point predicted, const OutlineReference& reference,
                             const std::array<double, 2>& along, Candidate& out) {
    if (until_watched_ <= 0) return false;
    --until_watched_;
    const EdgeFitResult fit = bank_.fit(image, predicted);
    const bool as_before = judge(fit, reference, along, out) && !out.degraded && fit.trimmed < most_misfit &&
                           fit.noise < (rougher * roughness_ + rounding) * std::abs(fit.contrast);
    if (as_before) bank_.accept();
    return as_before;
}

void OutlineFollower::watch(const EdgeFitResult& fit, double blur) {
    until_watched_ = watched_every - 1;
    roughness_ = fit.noise / std::abs(fit.contrast);
    if (std::abs(blur / bank_.blur() - 1) > other_blur) bank_.set_blur(blur);
}

}  // namespace shaker::tracking
