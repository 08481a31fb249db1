#pragma once
// Locator for a silhouette: its two edges across the shaker's axis.
#include <optional>

#include "tracking/image/edge_fit.hpp"
#include "tracking/image/profile.hpp"
#include "tracking/image/region.hpp"
#include "tracking/locator.hpp"
#include "tracking/outline_follower.hpp"
#include "tracking/outline_quality.hpp"

namespace shaker::tracking {

/// Rows between the edges are averaged in groups; each group and edge has its own gain and offset. A
/// silhouette that looks as it did is followed by filters of the means about its edges. Measures along the
/// image axis nearest to the shaker's; the other coordinate is the middle of the rows in use. The width is
/// measured when it is not given.
class RectangleLocator final : public Locator {
public:
    explicit RectangleLocator(Subject subject);
    Point learn(const ImageView& image) override;
    bool locate(const ImageView& image, Point predicted, Candidate& out) override;
    void search(const ImageView& image, Point last, Sweep sweep, std::vector<Candidate>& out) override;
    [[nodiscard]] double reach() const noexcept override { return 10; }
    [[nodiscard]] double extent() const noexcept override { return learned_.size; }
    [[nodiscard]] std::optional<Correction> correction() const override {
        return correction_of("width_mm", subject_.target.width_mm,
                             crossing_px(subject_, subject_.target.width_mm), 2 * learned_.size);
    }
    [[nodiscard]] bool interchangeable() const noexcept override { return true; }

private:
    void find_edges(const Box& box, double given);
    void find_rows(const ImageView& image, int first, int last, double centre);
    void gather(const ImageView& image, double centre);
    EdgeFitResult measure(const ImageView& image, double start, const EdgePrior& prior);
    [[nodiscard]] double pair_score(double centre) const;
    void doubt_size(double size, Candidate& out) const;
    void load_profile(const ImageView& image);
    [[nodiscard]] OutlineFollower::Sites sites() const;
    void begin(const Levels& levels);
    bool load_strip(const ImageView& image, double start);
    [[nodiscard]] ImageView strip() const noexcept;
    [[nodiscard]] double along(Point at) const noexcept { return axis_ == Axis::x ? at.x : at.y; }
    [[nodiscard]] Point place(double along) const noexcept;
    void watch(EdgeFitResult fit);
    std::optional<EdgeFitResult> fit_near(const ImageView& image, double at, Candidate& out);
    bool locate_with_care(const ImageView& image, double start, Candidate& out);
    bool accept(const EdgeFitResult& fit, Candidate& out) const;

    Subject subject_;
    Axis axis_;
    EdgeFit fit_{true};
    OutlineReference reference_;
    Outline learned_;
    double size_ = 0, blur_ = 0;  // now, px
    EdgePrior prior_;
    int row0_ = 0, row1_ = 0;
    std::vector<double> profile_, line_;
    OutlineFollower follower_;
    std::vector<float> strip_;  // means of each group of rows about the left edge, then about the right one
    int strip_origin_ = 0;      // column of the picture minus that of the strip, for the middle
};

}  // namespace shaker::tracking
