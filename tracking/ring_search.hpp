#pragma once
// Coarse search for discs: compares grey levels just inside and just outside a ring, on a grid of centres.
#include <vector>

#include "tracking/pixels.hpp"

namespace shaker {

/// A centre where a disc may be, to about 2 px, and its score: 1 for a whole rim of the expected contrast.
struct RingPeak {
    Point at;
    double score = 0;
};

/// Deterministic, constant time for a given area. Scratch memory is kept.
class RingSearch {
public:
    /// Radius and blur in px; sign +1 for a bright disc, -1 for a dark one.
    RingSearch(double radius, double blur, double sign);
    /// Replaces `out` by the local maxima with a score of at least `least`, best first, at most 64. Centres
    /// cover `box`, which may reach beyond the image: the part of a rim that is outside counts neither way.
    void scan(const ImageView& image, const Box& box, double contrast, double least,
              std::vector<RingPeak>& out);
    /// The score at one centre; 0 when less than a third of the rim is in the picture.
    [[nodiscard]] double score(const ImageView& image, int x, int y, double contrast) const;

private:
    struct Pair {
        int in_x, in_y, out_x, out_y;
    };
    template <class P>
    double score_at(const P& pixels, const Box& image, int x, int y, double contrast) const;

    std::vector<Pair> pairs_;
    std::vector<double> scores_;
    double sign_;
    double apart_;
    int step_;
};

}  // namespace shaker
