#pragma once
// Coarse search for discs: compares grey levels just inside and just outside a ring, on a grid of centres.
#include <vector>

#include "tracking/image/pixels.hpp"

namespace shaker::tracking {

/// Possible centre of a disc, to about 2 px. score: 1 for a complete rim of the expected contrast.
struct RingPeak {
    Point at;
    double score = 0;
};

/// Deterministic; time proportional to the area. Scratch memory is kept.
class RingSearch {
public:
    /// radius, blur: px; sign: +1 for a bright disc, -1 for a dark one.
    RingSearch(double radius, double blur, double sign);
    /// Replaces `out` by the local maxima with a score of at least `least`, best first, at most 64. Centres
    /// cover `box`, which may extend beyond the image: parts of a rim outside do not count.
    void scan(const ImageView& image, const Box& box, double contrast, double least,
              std::vector<RingPeak>& out);
    /// The score at one centre; 0 when less than a third of the rim is in the image.
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

}  // namespace shaker::tracking
