#pragma once
// SlipWatch: doubts a periodic target after a gap in which it may have slipped by whole pitches.
#include <algorithm>
#include <optional>

namespace shaker::tracking {

/// Bars and dots look alike after a move by a whole pitch, so a gap in which the target may have moved by
/// half a pitch leaves its place ambiguous. The possible move is the smaller of the fastest step times the
/// gap and of the range of all places, half as much again; after a gap longer than half of the time that the
/// target was watched, no move is excluded. A target that is found further away than it can have moved has
/// slipped by a known number of pitches. A target that once moves by a third of its pitch from one picture
/// to the next is sampled too seldom and stays in doubt. A target that oscillates about a fixed place (a
/// base) settles the doubt: once it has moved over its old range again, a shift of the middle of the range is
/// the slip.
///
/// The same rule holds for a target that something resembles at a distance; the distance is its pitch.
///
/// Places are px along the shaker's axis; times are counted in pictures.
class SlipWatch {
public:
    /// pitch: px; 0: the target is not periodic and is never doubted. oscillates: about a fixed place.
    SlipWatch(double pitch, bool oscillates) : pitch_{pitch}, oscillates_{oscillates} {}

    /// Takes a place that was found `pictures` after the one before. Returns the slip that is now known, px,
    /// 0 if there was none; nothing while there is no doubt, or while it stays. certain: it is not a
    /// neighbour that was found.
    std::optional<double> take(double place, double pictures, bool certain = false);
    /// Standard error of the newest place while it may be wrong by whole pitches: half a pitch, px; else 0.
    [[nodiscard]] double doubt_px() const noexcept { return doubts_ ? 0.5 * pitch_ : 0; }

private:
    /// Range of places.
    struct Span {
        double low = 0, high = 0;
        bool any = false;
        double seen = 0, grown = 0;  // pictures since the first place, and until it grew by more than slack
        void add(double place, double pictures, double slack);
        [[nodiscard]] double length() const noexcept { return high - low; }
        [[nodiscard]] double middle() const noexcept { return 0.5 * (low + high); }
        /// No growth for as long as it grew: an oscillation has shown its whole range.
        [[nodiscard]] bool whole() const noexcept { return seen > 2 * grown; }
    };

    double pitch_;
    bool oscillates_;
    Span before_, since_;  // since_: after the gap
    double last_ = 0, fastest_ = 0;
    bool doubts_ = false;
};

}  // namespace shaker::tracking
