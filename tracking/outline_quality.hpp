#pragma once
// Decides whether a fitted outline is the target learned in frame 0.
#include <array>

#include "tracking/image/edge_fit.hpp"
#include "tracking/locator.hpp"

namespace shaker::tracking {

/// Properties of the target in frame 0. Contrast is positive for the requested polarity.
struct OutlineReference {
    Outline outline;
    double sign = 1;
    double contrast = 0;
    double coverage = 0;
    double noise = 0;
    double trimmed = 0;  // of the outline, where other things lie on it
};

/// Sets `out` from the fit. False when contrast, size, noise or the visible share of the outline do not
/// match. `along`: direction of the standard deviation.
bool judge(const EdgeFitResult& fit, const OutlineReference& reference, const std::array<double, 2>& along,
           Candidate& out);

/// The residuals are larger than `times` those of frame 0, also in shares of the contrast: light that fades
/// leaves the noise as it was.
bool rougher(const EdgeFitResult& fit, const OutlineReference& reference, double times) noexcept;

}  // namespace shaker::tracking
