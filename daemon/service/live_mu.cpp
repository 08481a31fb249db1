#include "daemon/service/live_mu.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "daemon/reduction/series.hpp"
#include "drivers/errors.hpp"

namespace shaker::service {

namespace {

constexpr std::size_t newest_points = 40;  // 0.1 s of work

}  // namespace

void LiveMu::add(const reduction::Reduction& result, const Drive& asked) {
    law::Point point = law::point_of(result, asked);
    if (!std::isfinite(point.v_D.value) || !(point.v_D.sigma > 0) || point.base.order() == 0) return;
    point.number = points_.empty() ? 1 : points_.back().number + 1;
    const auto partner = std::ranges::find_if(
        points_, [&](const law::Point& p) { return p.partner == 0 && reduction::mirrored(p.asked, asked); });
    if (partner != points_.end()) {
        partner->partner = point.number;
        point.partner = partner->number;
    }
    if (points_.size() == newest_points) points_.erase(points_.begin());
    points_.push_back(std::move(point));
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

}  // namespace shaker::service
