#include "tracking/slip_watch.hpp"

#include <cmath>

namespace shaker::tracking {

namespace {

constexpr double margin = 1.5;         // a move may be so much larger than those that were seen
constexpr double longest_share = 0.5;  // of the time watched: a longer gap excludes no move
constexpr double covered = 0.8;        // share of the old range that must be covered again
constexpr double noise = 0.02;         // pitches: less is no growth of a range
constexpr double clear = 0.25;         // pitches: the middle of the range is known to this

}  // namespace

void SlipWatch::Span::add(double place, double pictures, double slack) {
    seen += any ? pictures : 0;
    if (!any || place < low - slack || place > high + slack) grown = seen;
    low = any ? std::min(low, place) : place;
    high = any ? std::max(high, place) : place;
    any = true;
}

std::optional<double> SlipWatch::take(double place, double pictures, bool certain) {
    if (pitch_ == 0) return std::nullopt;
    if (!before_.any || certain) {
        fastest_ = before_.any ? std::max(fastest_, std::abs(place - last_) / pictures) : 0;
        before_.add(place, pictures, noise * pitch_);
        last_ = place;
        doubts_ = false;
        return std::nullopt;
    }
    const bool gap = pictures > 1;
    const double move = margin * std::min(fastest_ * pictures, before_.length());
    if (move > 0.5 * pitch_ || (gap && pictures > longest_share * before_.seen)) {
        doubts_ = true;
        since_ = {};
    }
    if (gap && !doubts_) {
        // It moved by less than half a pitch: the rest was followed on something else.
        const double slip = pitch_ * std::round((place - last_) / pitch_);
        if (slip != 0) {
            last_ = place - slip;
            return slip;
        }
    }
    if (!doubts_) {
        fastest_ = std::max(fastest_, std::abs(place - last_) / pictures);
        before_.add(place, pictures, noise * pitch_);
    } else {
        since_.add(place, pictures, noise * pitch_);
    }
    last_ = place;
    if (!doubts_ || !oscillates_ || !since_.whole() || since_.length() < covered * before_.length())
        return std::nullopt;
    const double off = (since_.middle() - before_.middle()) / pitch_, slip = std::round(off);
    if (std::abs(off - slip) > clear) return std::nullopt;
    doubts_ = false;
    last_ -= slip * pitch_;
    return slip * pitch_;
}

}  // namespace shaker::tracking
