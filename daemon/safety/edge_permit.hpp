#pragma once
// EdgePermit: lets one drive start while the walker is beyond the edge limit, because it will walk inwards.
#include <algorithm>
#include <optional>

#include "daemon/safety/trip.hpp"

namespace shaker::safety {

/// Replaces the limit of the walker's distance from the edge, and nothing else, until the walker is inside.
/// The drive trips when the walker reaches the outer limit, is not seen, moves outwards, or does not move
/// inwards. Distances of the walker's outline from the picture's end, mm, positive in the picture.
class EdgePermit {
public:
    static constexpr double most_outwards_mm = 0.5;  // from its innermost place
    static constexpr int patience_periods = 20;      // of drive without a walk inwards
    static constexpr double least_inwards_mm = 0.1;  // in these periods
    static constexpr int most_lost_frames = 3;

    struct Place {
        double newest_mm = 0;
        double mean_mm = 0;  // over a period of the drive
    };
    /// start_mm: mean place at the start. inside_mm: mean place that ends the permit. outer_mm: the newest
    /// place may not be less.
    EdgePermit(double start_mm, double inside_mm, double outer_mm) noexcept
        : inside_mm_{inside_mm}, outer_mm_{outer_mm}, innermost_mm_{start_mm}, reference_mm_{start_mm} {}

    /// The outer limit of a walker whose last trip at the edge was at tripped_mm: 2 mm farther out, or the
    /// end of the picture.
    static double outer_limit_mm(double tripped_mm) noexcept { return std::max(0.0, tripped_mm - 2); }

    /// Judges the newest place; empty: not known. lost: consecutive frames without the walker. periods: of
    /// drive since the last soft start. A trip when the permit is withdrawn.
    [[nodiscard]] std::optional<Trip> judge(const std::optional<Place>& place, int lost,
                                            double periods) noexcept;
    /// The walker is inside: the ordinary limit is in force again.
    [[nodiscard]] bool over() const noexcept { return over_; }

private:
    double inside_mm_, outer_mm_;
    double innermost_mm_;
    double reference_mm_;     // last place that was counted as a walk inwards
    double progress_at_ = 0;  // periods
    bool over_ = false;
};

}  // namespace shaker::safety
