#pragma once
// Locator for several dots of one pitch that move as one rigid body.
#include "tracking/image/edge_fit.hpp"
#include "tracking/image/region.hpp"
#include "tracking/image/ring_search.hpp"
#include "tracking/locator.hpp"
#include "tracking/outline_follower.hpp"
#include "tracking/outline_quality.hpp"

namespace shaker::tracking {

/// The position is the mean of the dots that were in the region in frame 0; it does not change when some of
/// them leave the view. The row is periodic: after a loss the search covers half a pitch around the last
/// position.
class DotsLocator final : public Locator {
public:
    explicit DotsLocator(Subject subject);
    Point learn(const ImageView& image) override;
    bool locate(const ImageView& image, Point predicted, Candidate& out) override;
    void search(const ImageView& image, Point last, Sweep sweep, std::vector<Candidate>& out) override;
    [[nodiscard]] double reach() const noexcept override { return 0.4 * pitch_; }
    [[nodiscard]] double extent() const noexcept override { return 0.5 * pitch_; }
    [[nodiscard]] double pitch() const noexcept override { return pitch_; }
    [[nodiscard]] std::optional<Correction> correction() const override {
        return correction_of("diameter_mm", subject_.target.diameter_mm,
                             subject_.target.diameter_mm / subject_.mm_per_px, disc_diameter(learned_));
    }
    [[nodiscard]] bool interchangeable() const noexcept override { return false; }

private:
    void gather(const ImageView& image, Point centre);
    [[nodiscard]] OutlineFollower::Sites sites() const;
    void find_dots(const ImageView& image, const Box& box, double contrast);
    void check_pitch() const;
    EdgeFitResult measure(const ImageView& image, Point start);
    void watch(const ImageView& image, const EdgeFitResult& fit);

    Subject subject_;
    double sign_, pitch_;
    EdgeFit fit_;
    OutlineFollower follower_;
    RingSearch ring_;
    std::vector<Point> offsets_;
    Outline learned_;
    EdgePrior prior_;
    OutlineReference reference_;
    double blur_ = 1;
};

}  // namespace shaker::tracking
