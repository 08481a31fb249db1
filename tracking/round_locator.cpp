#include "tracking/round_locator.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>

namespace shaker::tracking {

namespace {

// Monotone in the angle, without an arc tangent: 0..4 for one turn.
double diamond_angle(double dx, double dy) noexcept {
    const double sum = std::abs(dx) + std::abs(dy);
    if (!(sum > 0)) return 0;
    const double t = dy / sum;
    return dx >= 0 ? (dy >= 0 ? t : 4 + t) : 2 - t;
}

}  // namespace

// A disc alone is divided into sectors.
int RoundLocator::block_of(std::size_t disc, double dx, double dy) const noexcept {
    if (pitch() > 0) return static_cast<int>(disc);
    return std::min(static_cast<int>(0.25 * blocks_ * diamond_angle(dx, dy)), blocks_ - 1);
}

RoundLocator::Sites RoundLocator::sites() const {
    Sites all;
    for (std::size_t k = 0; k < discs_.size(); ++k) {
        const Point disc = discs_[k];
        for (int y = static_cast<int>(std::ceil(disc.y - outer())); y <= disc.y + outer(); ++y) {
            for (int x = static_cast<int>(std::ceil(disc.x - outer())); x <= disc.x + outer(); ++x) {
                const double dx = x - disc.x, dy = y - disc.y, r = std::hypot(dx, dy);
                if (r >= inner() && r <= outer()) all.push_back({x, y, block_of(k, dx, dy)});
            }
        }
    }
    std::ranges::stable_sort(all, {}, &OutlineBank::Site::block);
    return all;
}

void RoundLocator::gather(const ImageView& image, Point centre, int every) {
    auto& samples = fit_.samples();
    samples.clear();
    const double wide = outer(), narrow = inner();
    with_pixels(image, [&](auto pixels) {
        for (std::size_t k = 0; k < discs_.size(); ++k) {
            const Point shift = discs_[k], disc = centre + shift;
            // One of many is left out before it is cut.
            if (pitch() > 0 && (std::ceil(disc.x - wide) < 0 || std::floor(disc.x + wide) >= image.width))
                continue;
            const int y0 = std::max(0, static_cast<int>(std::ceil(disc.y - wide)));
            const int y1 = std::min(image.height - 1, static_cast<int>(std::floor(disc.y + wide)));
            for (int y = y0; y <= y1; ++y) {
                const auto* row = pixels.row(y);
                const double dy = y - disc.y;
                const double half = std::sqrt(std::max(0.0, wide * wide - dy * dy));
                const double hole = std::sqrt(std::max(0.0, narrow * narrow - dy * dy));
                const int x0 = std::max(0, static_cast<int>(std::ceil(disc.x - half)));
                const int x1 = std::min(image.width - 1, static_cast<int>(std::floor(disc.x + half)));
                for (int x = x0 + y % every; x <= x1; x += every) {
                    const double dx = x - disc.x;
                    if (std::abs(dx) < hole) {
                        const int inside = static_cast<int>(std::floor(disc.x + hole)) - x;
                        x += inside / every * every;
                        continue;
                    }
                    samples.push_back(
                        {x - shift.x, y - shift.y, static_cast<double>(row[x]), block_of(k, dx, dy)});
                }
            }
        }
    });
}

EdgeFitResult RoundLocator::measure_peak(const ImageView& image, const RingPeak& peak, double contrast,
                                         double roughest) {
    const Point start = ring_.refine(image, peak.at, contrast);
    EdgeFitResult fit = measure(image, start, prior_);
    fit.converged = fit.converged && sign_ * fit.contrast > 0.25 * contrast &&
                    fit.noise < roughest * std::abs(fit.contrast) &&
                    std::abs(fit.outline.size / size_ - 1) < 0.2 &&
                    length(place_of(fit) - start) < (pitch() > 0 ? rim() : 6);
    return fit;
}

InputError RoundLocator::not_found(const char* what, double size) const {
    return InputError{
        fmt::format("{}: found no {} {} of {:.4g} px diameter; check the region, polarity and diameter_mm",
                    subject_.label, sign_ > 0 ? "bright" : "dark", what, 2 * size)};
}

}  // namespace shaker::tracking
