#pragma once
// Coarse search for discs: compares grey levels just inside and just outside a ring, on a grid of centres.
#include <cstdint>
#include <vector>

#include "tracking/image/pixels.hpp"

namespace shaker::tracking {

/// Possible centre of a disc, to about 2 px. score: 1 for a complete rim of the expected contrast.
struct RingPeak {
    Point at;
    double score = 0;
};

/// Large discs are looked for in a reduced picture, whose pixels are means. Deterministic; time proportional
/// to the area. Scratch memory is kept.
class RingSearch {
public:
    /// radius, blur: px; sign: +1 for a bright disc, -1 for a dark one.
    RingSearch(double radius, double blur, double sign);
    /// Replaces `out` by the local maxima with a score of at least `least`, best first, at most 64. Centres
    /// cover `box`, which may extend beyond the image: parts of a rim outside do not count. The peaks are
    /// places of the reduced picture: refine() leads to 2 px.
    void scan(const ImageView& image, const Box& box, double contrast, double least,
              std::vector<RingPeak>& out);
    /// The best centre in a cell of the reduced picture and around it.
    [[nodiscard]] Point refine(const ImageView& image, Point peak, double contrast) const;
    /// The score at one centre; 0 when less than a fifth of the rim is in the image.
    [[nodiscard]] double score(const ImageView& image, int x, int y, double contrast) const;
    /// Rows of a box of this width that scan() covers in about 0.1 ms.
    [[nodiscard]] int rows_at_a_time(int width) const noexcept;

private:
    struct Pair {
        int in_x, in_y, out_x, out_y;
    };
    static std::vector<Pair> ring(double radius, double margin);
    void reduce(const ImageView& image, const Box& box, double contrast);
    void score_row(int y, int first, int count);
    void keep_peaks(std::vector<RingPeak>& all) const;

    double sign_, apart_;
    int cell_;                                 // px, side of a pixel of the reduced picture
    std::vector<Pair> pairs_, reduced_pairs_;  // in their pictures
    // The reduced picture: its first cell, size, and levels in 1/128 of the contrast.
    int x0_ = 0, y0_ = 0, columns_ = 0, rows_ = 0;
    std::vector<std::int16_t> levels_;
    std::vector<double> means_;
    std::vector<std::int16_t> sums_, seen_;  // of one row of centres
};

}  // namespace shaker::tracking
