#pragma once
// What locators of outlines share: filters follow a target that looks as it did, a careful fit watches them.
#include <optional>
#include <vector>

#include "tracking/image/edge_fit.hpp"
#include "tracking/image/outline_bank.hpp"
#include "tracking/locator.hpp"

namespace shaker::tracking {

/// A kind writes its appearance: the pixels that show its outline, their blocks, and how a place is found
/// coarsely. A target that is hidden in part, blurred, faded or farther away than predicted is left to the
/// careful fit. Every 16th picture is given to it too, thinned; straight and round outlines take turns: one
/// pair of pictures from above and from the side does not pay for both. Points are those of the fit: of the
/// picture, or, of straight outlines, their place along the axis and 0.
class OutlineLocator : public Locator {
public:
    bool locate(const ImageView& image, Point predicted, Candidate& out) override;
    [[nodiscard]] double extent() const noexcept override { return learned_.size; }

protected:
    using Sites = std::vector<OutlineBank::Site>;
    static constexpr double precise = 3e-3, coarse = 0.1;  // px, of a last step
    static constexpr int searched_pixels = 1500;           // with which a place of a search is tried

    /// straight: edges across x at +-size instead of circles.
    OutlineLocator(Subject subject, bool straight);

    /// Fills the samples of the fit about a centre. every: takes one of so many pixels.
    virtual void gather(const ImageView& image, Point centre, int every) = 0;
    /// The pixels of the filters, block by block.
    [[nodiscard]] virtual Sites sites() const = 0;
    /// px on either side of an edge that are read.
    [[nodiscard]] virtual double rim() const noexcept = 0;
    /// Blocks are small targets on a slope of the background. They have no parts that could disagree: what
    /// cuts one shows in the residuals only.
    [[nodiscard]] virtual bool plane() const noexcept { return false; }
    [[nodiscard]] EdgeFit::Ground ground() const noexcept {
        return plane() ? EdgeFit::Ground::plane : EdgeFit::Ground::flat;
    }
    /// Prepares what the filters see about a place; false when they would not find the outline there.
    virtual bool look(const ImageView& image, Point at) = 0;
    /// Where the filters do not follow.
    virtual bool find_near(const ImageView& image, Point predicted, Candidate& out) = 0;
    /// The careful fit about a place, which sets `out`; not converged when that is not the target.
    virtual EdgeFitResult fit_near(const ImageView& image, Point at, Candidate& out);

    /// What the next fits start from.
    void expect(const Outline& outline) noexcept;
    EdgeFitResult measure(const ImageView& image, Point start, const EdgePrior& prior,
                          double enough = precise, int every = 1);
    /// fit: the target's in frame 0. shifts: of its blocks, px. means: as OutlineBank::Shape::means.
    void begin(const EdgeFitResult& fit, const Levels& levels, const std::vector<Point>& shifts,
               int means = 0);
    /// Sets `out` by a careful fit. False when contrast, size, noise or the visible share of the outline do
    /// not match.
    bool is_target(const EdgeFitResult& fit, Candidate& out) const;
    /// The residuals are larger than `times` those of frame 0, also in shares of the contrast: light that
    /// fades leaves the noise as it was.
    [[nodiscard]] bool rougher(const EdgeFitResult& fit, double times) const noexcept;
    /// Accepts the target at `at` when that is near the predicted place.
    bool try_at(const ImageView& image, Point at, Point predicted, Candidate& out);
    /// The filters' place, or the predicted one where they have none.
    [[nodiscard]] Point start() const noexcept { return start_; }

    Subject subject_;
    double sign_;  // of the contrast
    std::array<double, 2> along_;
    EdgeFit fit_;
    Outline learned_;             // in frame 0
    double size_ = 0, blur_ = 1;  // now, px
    double most_growth_ = 0;      // px a picture, of the size
    EdgePrior prior_;
    int blocks_ = 1;
    double contrast_ = 0, noise_ = 0, trimmed_ = 0;  // in frame 0; contrast: positive
    int search_every_ = 1;                           // pixels, for searched_pixels
    // What the filters see, and its origin.
    ImageView seen_;
    Point origin_;

private:
    bool judge(const EdgeFitResult& fit, Candidate& out) const;
    bool follow(Point predicted, Candidate& out);
    void watch(EdgeFitResult fit);
    void filter(Point at);

    bool straight_;
    double coverage_ = 0;            // in frame 0
    std::array<double, 2> slope_{};  // in frame 0
    int watch_every_ = 1;            // pixels
    OutlineBank bank_;
    EdgeFitResult own_;  // by the filters, of the newest picture
    Point start_;
    bool trusted_ = false, followed_ = false;  // followed_: the newest picture, by follow()
    int picture_ = 0;                          // of 16; 0 is watched
    double roughness_ = 0;                     // noise / contrast, watched
    // Share that does not fit, by the filters and by the careful fit; outline in use, careful fit over
    // filters.
    double own_misfit_ = 0, watched_misfit_ = 0, coverage_ratio_ = 1;
};

}  // namespace shaker::tracking
