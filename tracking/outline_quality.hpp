#pragma once
// Whether a fitted outline is the target that was learned in frame 0.
#include <array>

#include "tracking/edge_fit.hpp"
#include "tracking/locator.hpp"

namespace shaker {

/// What frame 0 showed. Contrast is positive for the polarity asked for.
struct OutlineReference {
    Outline outline;
    double sign = 1;
    double contrast = 0;
    double coverage = 0;
    double noise = 0;
};

/// Fills `out` from the fit; false when contrast, size, noise or the share of the outline in view do not fit.
/// `along` is the direction the standard deviation is given for.
bool judge(const EdgeFitResult& fit, const OutlineReference& reference, const std::array<double, 2>& along,
           Candidate& out);

}  // namespace shaker
