#include "daemon/service/live_mu.hpp"

#include <algorithm>

#include "drivers/errors.hpp"

namespace shaker::service {

namespace {

constexpr std::size_t newest_points = 40;  // 0.1 s of work
constexpr double refused_share = 0.2;      // error of a mu whose law the measurements refuse

}  // namespace

void LiveMu::add(const reduction::Reduction& result, const Drive& asked) {
    if (!law::add_paired(points_, law::point_of(result, asked))) return;
    if (points_.size() > newest_points) points_.erase(points_.begin());
    newer_ = true;
}

bool LiveMu::follow() {
    if (newer_ && !fit_.valid()) {
        newer_ = false;
        try {
            fit_ = fitter_.run(
                [points = points_, options = law::CoulombOptions{.g = g_, .start_mu = mu_.value}] {
                    return law::fit_coulomb(points, options);
                });
        } catch (const DeviceError& e) {
            mu_ = {.note = e.what()};
            return true;
        }
    }
    if (!is_ready(fit_)) return false;
    mu_ = fit_.get().mu;
    return true;
}

calibration::Estimate LiveMu::to_predict() const noexcept {
    return {mu_.value, mu_.refused ? std::max(mu_.error, refused_share * mu_.value) : mu_.error};
}

}  // namespace shaker::service
