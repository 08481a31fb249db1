#include "daemon/safety/edge_permit.hpp"

namespace shaker::safety {

std::optional<Trip> EdgePermit::judge(const std::optional<Place>& place, int lost, double periods) noexcept {
    if (over_) return std::nullopt;
    if (!place || lost >= most_lost_frames)
        return Trip{.cause = Cause::tracking_lost,
                    .value = static_cast<double>(std::max(lost, 1)),
                    .limit = most_lost_frames};
    const auto too_far_out = [](double mm, double least_mm) {
        return Trip{.cause = Cause::walker_edge, .value = mm, .limit = least_mm};
    };
    if (place->newest_mm < outer_mm_) return too_far_out(place->newest_mm, outer_mm_);
    if (place->mean_mm >= inside_mm_) {
        over_ = true;
        return std::nullopt;
    }
    innermost_mm_ = std::max(innermost_mm_, place->mean_mm);
    if (place->mean_mm < innermost_mm_ - most_outwards_mm)
        return too_far_out(place->mean_mm, innermost_mm_ - most_outwards_mm);
    progress_at_ = std::min(progress_at_, periods);
    if (place->mean_mm >= reference_mm_ + least_inwards_mm) {
        reference_mm_ = place->mean_mm;
        progress_at_ = periods;
    }
    if (periods - progress_at_ <= patience_periods) return std::nullopt;
    return too_far_out(place->mean_mm, reference_mm_ + least_inwards_mm);
}

}  // namespace shaker::safety
