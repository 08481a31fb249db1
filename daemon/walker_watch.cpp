#include "daemon/walker_watch.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/drive.hpp"

namespace shaker {

namespace {

constexpr std::size_t most_drifts = 1000;  // what settles does so in fewer

// Of the outline from the nearer end of the picture, along the shaker's axis.
double edge_distance_mm(const Track& t, const Target& target, const CameraTake& camera) {
    const bool across = std::abs(camera.view.along[1]) > std::abs(camera.view.along[0]);
    const double at = across ? t.fix.y_px : t.fix.x_px, size = across ? camera.height : camera.width;
    const double extent_mm = std::max(target.diameter_mm, target.width_mm);
    return std::min(at, size - at) * camera.view.mm_per_px - 0.5 * extent_mm;
}

}  // namespace

void WalkerWatch::add(const Take& take) {
    const auto walker =
        std::ranges::find_if(take.tracks, [](const auto& t) { return t.target.name == "walker"; });
    watches_ = walker != take.tracks.end();
    if (!watches_) return;
    const auto camera =
        std::ranges::find(take.cameras, walker->camera, [](const CameraTake& c) { return c.view.camera; });
    seen_ = std::max(seen_, walker->dropped);
    for (; seen_ < walker->dropped + walker->tracks.size(); ++seen_) {
        const Track& t = walker->tracks[seen_ - walker->dropped];
        lost_ = found(t.fix.state) ? 0 : lost_ + 1;
        if (!std::isfinite(seconds(t.time))) continue;
        until_s_ = std::max(until_s_, seconds(t.time));
        if (!found(t.fix.state)) continue;
        x_m_ = t.x_m;
        if (camera != take.cameras.end() && camera->width > 0)
            edge_mm_ = edge_distance_mm(t, walker->target, *camera);
        if (const auto period = fold_.add(seconds(t.time), t.x_m, t.sd_m)) drifts_.push_back(*period);
        if (drifts_.size() > most_drifts) drifts_.pop_front();
    }
}

bool WalkerWatch::settled_since(double from_s, double gamma) const {
    std::vector<double> since;
    double sigma = 1e-4 * gamma / (two_pi * frequency_ * frequency_);
    for (const PeriodFold::Period& p : drifts_) {
        if ((p.k - 1) / frequency_ < from_s) continue;  // a drift spans two periods
        since.push_back(p.drift.value);
        sigma = std::max(sigma, p.drift.sigma);
    }
    return settled(since, sigma);
}

}  // namespace shaker
