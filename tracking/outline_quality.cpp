#include "tracking/outline_quality.hpp"

#include <algorithm>
#include <cmath>

namespace shaker::tracking {

bool judge(const EdgeFitResult& fit, const OutlineReference& reference, const std::array<double, 2>& along,
           Candidate& out) {
    if (!fit.converged) return false;
    const auto& [x, y, size, blur] = fit.outline;
    const Outline& learned = reference.outline;
    const double contrast = reference.sign * fit.contrast;
    const double share = std::min(1.0, fit.coverage / reference.coverage);
    const double misfit = std::max(0.0, fit.trimmed - reference.trimmed);
    // Noise that stays while the light fades is accepted; a larger misfit is another object.
    const double roughest = std::clamp(3 * reference.noise / reference.contrast, 0.12, 0.35);
    const Eigen::Vector2d axis{along[0], along[1]};
    const double sd = std::sqrt(axis.dot(fit.covariance * axis));
    const bool good = contrast > 0.35 * reference.contrast && contrast < 3 * reference.contrast &&
                      share > 0.25 && misfit < 0.35 && fit.noise < roughest * contrast && sd < 0.5 &&
                      std::abs(size - learned.size) < std::max(0.8, 0.06 * learned.size) &&
                      blur < 2.5 * learned.blur + 0.5;
    if (!good) return false;
    out.at = {x, y};
    out.sd = sd;
    out.likeness = share * (1 - misfit);
    out.degraded = share < 0.75 || misfit > 0.12 || blur > 1.4 * learned.blur + 0.2;
    return true;
}

bool rougher(const EdgeFitResult& fit, const OutlineReference& reference, double times) noexcept {
    const double smooth = times * reference.noise;
    return fit.noise > smooth && fit.noise * reference.contrast > smooth * reference.sign * fit.contrast;
}

}  // namespace shaker::tracking
