#pragma once
// Pixels at the end of a sensor's range.
#include <array>
#include <cstdint>
#include <vector>

#include "tracking/image/pixels.hpp"

namespace shaker::tracking {

/// Share of a box's pixels that have the largest code of their depth (2^k - 1, k >= 8, or that shifted to the
/// left), from at most 32 of its rows. 0 for a box outside the image.
double clipped_share(const ImageView& image, const Box& box);

/// Sees that the bright side of a target is clipped.
class ClippingWatch {
public:
    /// Takes the next picture in which the target is in `box`. True when many of its pixels have the last
    /// code, or, from a camera with noise (`noisy`), when most bright pixels in it or just beside it have one
    /// code, or the one that they had in the picture before, while the dark ones differ: they are clipped at
    /// whatever code, or were before the camera evened them out.
    bool clipped(const ImageView& image, const Box& box, bool noisy);

private:
    struct Pairs {
        double all = 0, equal = 0;  // pixels that are bright, or dark, in two pictures in turn
    };
    void compare(const ImageView& image);
    void remember(const ImageView& image, const Box& box);

    std::vector<std::array<int, 2>> sites_;  // x, y
    std::vector<std::uint16_t> codes_;       // of the sites, in the newest picture
    std::vector<std::uint16_t> sorted_;
    double low_ = 0, high_ = 0;  // of the codes
    Pairs bright_, dark_;        // where they are few, with those of earlier pictures, which fade
    Pairs heap_;                 // bright pixels of the newest picture; equal: that have the highest code
};

}  // namespace shaker::tracking
