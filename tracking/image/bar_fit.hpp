#pragma once
// BarModel: edges and levels of bars across a profile.
#include <span>
#include <vector>

namespace shaker::tracking {

/// Steps between constant levels, blurred by a Gaussian and averaged over each pixel.
struct BarModel {
    std::vector<double> edges;   // px, ascending
    std::vector<double> levels;  // one more than edges
    double blur = 0.7;           // sigma of the Gaussian, px
    double explained = 0;        // share of the profile's variance

    struct Value {
        double level, slope, by_blur;  // slope: per px; by_blur: change of the level by the blur, per px
    };
    [[nodiscard]] Value at(double x) const noexcept;
    [[nodiscard]] double narrowest() const noexcept;
};

/// Finds the edges in a profile, which are where it crosses the middle between its neighbours' extremes, and
/// fits places, levels and blur by least squares. Without an edge: no edges.
BarModel fit_bars(std::span<const double> profile);

}  // namespace shaker::tracking
