#pragma once
// Several dots of one pitch that move as one: a rigid position from all of them.
#include "tracking/edge_fit.hpp"
#include "tracking/locator.hpp"
#include "tracking/outline_quality.hpp"
#include "tracking/region.hpp"
#include "tracking/ring_search.hpp"

namespace shaker {

/// The position is the mean of the dots that were in the region in frame 0, whichever of them are still in
/// view. The row repeats itself, so after a loss it is looked for within half a pitch of where it was last.
class DotsLocator final : public Locator {
public:
    explicit DotsLocator(Subject subject);
    Point learn(const ImageView& image) override;
    bool locate(const ImageView& image, Point predicted, Candidate& out) override;
    void search(const ImageView& image, Point last, std::vector<Candidate>& out) override;
    [[nodiscard]] double reach() const noexcept override { return 0.4 * pitch_; }
    [[nodiscard]] double extent() const noexcept override { return 0.5 * pitch_; }
    [[nodiscard]] bool interchangeable() const noexcept override { return false; }

private:
    void gather(const ImageView& image, Point centre);
    void find_dots(const ImageView& image, const Box& box, double contrast);
    void check_pitch() const;
    EdgeFitResult measure(const ImageView& image, Point start);

    Subject subject_;
    double sign_, pitch_;
    EdgeFit fit_;
    RingSearch ring_;
    std::vector<Point> offsets_;
    Outline learned_;
    EdgePrior prior_;
    OutlineReference reference_;
    double blur_ = 1;
};

}  // namespace shaker
