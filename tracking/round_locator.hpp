#pragma once
// What the locators of a disc and of a row of dots share.
#include <optional>
#include <vector>

#include "tracking/image/ring_search.hpp"
#include "tracking/outline_locator.hpp"

namespace shaker::tracking {

inline Point place_of(const EdgeFitResult& fit) noexcept { return {fit.outline.x, fit.outline.y}; }

/// One or more discs of one size about a common centre.
class RoundLocator : public OutlineLocator {
public:
    [[nodiscard]] std::optional<Correction> correction() const override {
        return correction_of("diameter_mm", subject_.target.diameter_mm,
                             subject_.target.diameter_mm / subject_.mm_per_px, disc_diameter(learned_));
    }

protected:
    explicit RoundLocator(Subject subject) : OutlineLocator{std::move(subject), false} {
        prior_.sign = sign_;
    }
    void gather(const ImageView& image, Point centre, int every) override;
    [[nodiscard]] Sites sites() const override;
    [[nodiscard]] double inner() const noexcept { return plane() ? 0 : learned_.size - rim(); }
    [[nodiscard]] double outer() const noexcept { return learned_.size + rim(); }
    [[nodiscard]] int block_of(std::size_t disc, double dx, double dy) const noexcept;
    /// Converged when it is a disc of about the size that is expected. roughest: residual over contrast.
    EdgeFitResult measure_peak(const ImageView& image, const RingPeak& peak, double contrast,
                               double roughest);
    [[nodiscard]] InputError not_found(const char* what, double size) const;

    RingSearch ring_{4, 1, 1};
    std::vector<RingPeak> peaks_;
    std::vector<Point> discs_{{0, 0}};  // about the common centre
};

}  // namespace shaker::tracking
