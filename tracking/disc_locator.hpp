#pragma once
// Locator for a disc or a single dot: fit of its rim.
#include <limits>

#include "tracking/image/edge_fit.hpp"
#include "tracking/image/region.hpp"
#include "tracking/image/ring_search.hpp"
#include "tracking/locator.hpp"
#include "tracking/outline_follower.hpp"
#include "tracking/outline_quality.hpp"

namespace shaker::tracking {

/// Large discs are divided into sectors with their own gain and offset, so that hidden or reflecting parts of
/// the rim can be excluded; small ones are one block on a plane of background. The diameter is measured when
/// it is not given, or is wrong by up to 4 %.
class DiscLocator final : public Locator {
public:
    explicit DiscLocator(Subject subject);
    Point learn(const ImageView& image) override;
    bool locate(const ImageView& image, Point predicted, Candidate& out) override;
    void search(const ImageView& image, Point last, Sweep sweep, std::vector<Candidate>& out) override;
    [[nodiscard]] double reach() const noexcept override { return 10; }
    [[nodiscard]] double extent() const noexcept override { return learned_.size; }
    [[nodiscard]] std::optional<Correction> correction() const override {
        return correction_of("diameter_mm", subject_.target.diameter_mm,
                             subject_.target.diameter_mm / subject_.mm_per_px, disc_diameter(learned_));
    }
    [[nodiscard]] bool interchangeable() const noexcept override { return true; }

private:
    void watch(const ImageView& image, const EdgeFitResult& fit);
    bool is_target(const EdgeFitResult& fit, Candidate& out) const;
    [[nodiscard]] bool small() const noexcept { return learned_.size < 16; }
    bool find(const ImageView& image, const Box& box, double size, double contrast, EdgeFitResult& fit);
    double misfit_in(const ImageView& image, const Box& box, const EdgeFitResult& whole);
    // every: takes one of so many pixels.
    void gather(const ImageView& image, Point centre, int every);
    [[nodiscard]] OutlineFollower::Sites sites() const;
    [[nodiscard]] int block_of(double dx, double dy) const noexcept;
    EdgeFitResult measure(const ImageView& image, Point start, double enough = 3e-3, int every = 1);
    double radius_by_threshold(const ImageView& image, const Box& box, const Levels& levels) const;
    void try_peaks(const ImageView& image, Sweep sweep, std::vector<Candidate>& out);
    [[nodiscard]] Box around(Point at) const noexcept;
    [[nodiscard]] bool inside(const ImageView& image, Point at) const noexcept;

    Subject subject_;
    double sign_;
    EdgeFit fit_;
    OutlineFollower follower_;
    RingSearch ring_;
    std::vector<RingPeak> peaks_;
    Outline learned_;
    EdgePrior prior_;
    OutlineReference reference_;
    double contrast_ = 0, blur_ = 1;
    int blocks_ = 1;
    // Progress of a search that takes several pictures.
    std::size_t tries_ = 2, turn_ = 0;
    int search_every_ = 1, watch_every_ = 1;
    int next_row_ = std::numeric_limits<int>::max();
};

}  // namespace shaker::tracking
