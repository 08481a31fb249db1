#include "daemon/law/asked_drive.hpp"

#include <spdlog/fmt/fmt.h>

#include <cmath>

#include "drivers/errors.hpp"

namespace shaker::law {

AskedDrive on_asked_drive(const Point& point, const LawPoint& at, const CoulombFit& fit) try {
    AskedDrive out;
    if (!fit.known()) {
        out.reason = "mu is not known: " + fit.mu.note;
        return out;
    }
    Point asked = point;
    asked.frequency = point.asked.frequency;
    asked.base = harmonics(point.asked);
    asked.base_sd = {};
    const LawPoint ideal = law_point(asked, Coulomb{.mu = fit.law.mu, .g = fit.law.g});
    out.correction = ideal.v_D - at.v_D;
    const double tilt_error = std::isfinite(fit.tilt.error) ? fit.tilt.error : 0;
    out.model_error =
        std::hypot(at.base_error, (ideal.by_mu - at.by_mu) * fit.mu.error, at.by_tilt * tilt_error);
    const double scale = velocity_scale(point);
    if (std::abs(out.correction) > largest_correction * scale)
        out.reason = fmt::format(
            "the correction of {:.3g} mm/s is {:.2g} % of gamma/omega; at most {:.0f} % is corrected",
            1e3 * out.correction, 100 * std::abs(out.correction) / scale, 100 * largest_correction);
    else if (!(std::abs(at.z) <= farthest_from_law))
        out.reason = fmt::format(
            "the law at the measured base misses v_D by {:.1f} errors; at most {:.0f} are allowed",
            std::abs(at.z), farthest_from_law);
    else
        out.v_D = {point.v_D.value + out.correction, std::hypot(point.v_D.sigma, out.model_error)};
    return out;
} catch (const InputError& error) {
    AskedDrive out;
    out.reason = std::string{"the law has no settled motion on the asked drive: "} + error.what();
    return out;
}

}  // namespace shaker::law
