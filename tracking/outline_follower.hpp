#pragma once
// Decides whether a fitted outline is the target learned in frame 0, and follows an outline that looks as it
// did by matched filters, where the careful fit watches.
#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>

#include "tracking/image/edge_fit.hpp"
#include "tracking/image/outline_bank.hpp"
#include "tracking/locator.hpp"

namespace shaker::tracking {

/// Properties of the target in frame 0. Contrast is positive for the requested polarity.
struct OutlineReference {
    Outline outline;
    double sign = 1;
    double contrast = 0;
    double coverage = 0;
    double noise = 0;
    double trimmed = 0;  // of the outline, where other things lie on it
    std::array<double, 2> slope{};
};

/// Sets `out` from the fit. False when contrast, size, noise or the visible share of the outline do not
/// match. `along`: direction of the standard deviation.
bool judge(const EdgeFitResult& fit, const OutlineReference& reference, const std::array<double, 2>& along,
           Candidate& out);

/// The residuals are larger than `times` those of frame 0, also in shares of the contrast: light that fades
/// leaves the noise as it was.
bool rougher(const EdgeFitResult& fit, const OutlineReference& reference, double times) noexcept;

/// Times the residuals of frame 0: a small target is cut, or of another shape.
inline constexpr double cut_roughness = 1.2;

/// A mean of the fitted blurs that follows a lens out of focus at once.
inline double followed_blur(double blur, double fitted) noexcept {
    const double change = fitted - blur;
    return blur + (std::abs(change) > std::max(0.1 * blur, 0.15) ? 1 : 0.1) * change;
}

/// A target that is hidden in part, blurred, faded or farther away than predicted is left to the careful fit.
/// Every 16th picture is given to it too; it may be thinned then. Straight and round outlines take turns: one
/// pair of pictures from above and from the side does not pay for both.
class OutlineFollower {
public:
    using Sites = std::vector<OutlineBank::Site>;

    /// shape: of the target in frame 0. sites: its pixels, block by block.
    void begin(const OutlineBank::Shape& shape, Sites sites, const std::vector<Point>& shifts);
    /// False when the careful fit must decide; start() is where it begins. slopes: of the careful fit, which
    /// learn here too.
    bool follow(const ImageView& image, Point predicted, const OutlineReference& reference,
                const std::array<double, 2>& along, std::span<KnownSlope> slopes, Candidate& out);
    /// The careful fit shall watch this picture, which follow() has measured.
    [[nodiscard]] bool due() const noexcept;
    [[nodiscard]] Point start() const noexcept { return start_; }
    /// As OutlineBank::common(), which the errors of follow() contain.
    [[nodiscard]] double common() const noexcept { return bank_.common(); }
    /// Instead of follow(), in a picture that does not show the outline at the predicted place.
    void pass_over() noexcept { own_.converged = followed_ = false; }
    /// The careful fit of a picture that follow() left to it, or that was due. Where the filters disagree
    /// with it, it decides the next picture.
    /// size, blur: as they are now, px.
    void watch(const ImageView& image, const EdgeFitResult& fit, const std::array<double, 2>& along,
               double size, double blur, std::span<KnownSlope> slopes);

private:
    OutlineBank bank_;
    EdgeFitResult own_;  // of the newest picture
    Point start_;
    bool trusted_ = false, followed_ = false;  // followed_: the newest picture, by follow()
    int picture_ = 0;       // of 16; 0 is watched. Round and straight outlines do not begin at the same one
    double roughness_ = 0;  // noise / contrast, watched
    // Share that does not fit, by the filters and by the careful fit; outline in use, careful fit over
    // filters.
    double own_misfit_ = 0, watched_misfit_ = 0, coverage_ratio_ = 1;
};

}  // namespace shaker::tracking
