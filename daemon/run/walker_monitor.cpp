#include "daemon/run/walker_monitor.hpp"

#include <algorithm>
#include <cmath>

#include "calibration/camera/camera_scale.hpp"
#include "drivers/drive.hpp"

namespace shaker::run {

namespace {

constexpr std::size_t most_drifts = 1000;  // a drift that settles needs fewer

// Image y grows downwards and x to the right.
bool along_height(const View& view) { return std::abs(view.along[1]) > std::abs(view.along[0]); }

std::array<double, 2> picture_ends_m(const tracking::Track& t, const Target& target,
                                     const acquisition::CameraStream& camera) {
    const auto x_at = [&](double x_px, double y_px) {
        return calibration::metres_along(camera.view, target.offset_mm, x_px, y_px);
    };
    if (along_height(camera.view)) return {x_at(t.fix.x_px, 0), x_at(t.fix.x_px, camera.height)};
    return {x_at(0, t.fix.y_px), x_at(camera.width, t.fix.y_px)};
}

// Distance of the outline from the nearer end of the picture, along the shaker's axis.
double edge_distance_mm(const tracking::Track& t, const Target& target,
                        const acquisition::CameraStream& camera) {
    const bool across = along_height(camera.view);
    const double at = across ? t.fix.y_px : t.fix.x_px, size = across ? camera.height : camera.width;
    const double extent_mm = std::max(target.diameter_mm, target.width_mm);
    return std::min(at, size - at) * camera.view.mm_per_px - 0.5 * extent_mm;
}

}  // namespace

void WalkerMonitor::add(const acquisition::Streams& streams) {
    const auto camera_of = [&](const acquisition::TargetTrack& t) {
        return std::ranges::find(streams.cameras, t.camera,
                                 [](const acquisition::CameraStream& c) { return c.view.camera; });
    };
    const auto is_walker = [](const auto& t) { return t.target.name == "walker"; };
    const auto walker = std::ranges::find_if(streams.tracks, [&](const auto& t) {
        const auto c = camera_of(t);
        return is_walker(t) && (c == streams.cameras.end() || c->failure.empty());
    });
    watches_ = walker != streams.tracks.end();
    blind_ = !watches_ && std::ranges::any_of(streams.tracks, is_walker);
    if (!watches_) return;
    const auto camera = camera_of(*walker);
    if (walker->camera != camera_) follow(*walker);
    seen_ = std::max(seen_, walker->dropped);
    for (; seen_ < walker->dropped + walker->tracks.size(); ++seen_) {
        const tracking::Track& t = walker->tracks[seen_ - walker->dropped];
        lost_ = found(t.fix.state) ? 0 : lost_ + 1;
        if (!std::isfinite(seconds(t.time))) continue;
        until_s_ = std::max(until_s_, seconds(t.time));
        if (!found(t.fix.state)) continue;
        x_m_ = t.x_m;
        if (camera != streams.cameras.end() && camera->width > 0) {
            edge_mm_ = edge_distance_mm(t, walker->target, *camera);
            edges_.push_back({seconds(t.time), *edge_mm_});
            while (edges_.front().at_s <= edges_.back().at_s - 1 / frequency_) edges_.pop_front();
            ends_m_ = picture_ends_m(t, walker->target, *camera);
        }
        if (const auto period = fold_.add(seconds(t.time), t.x_m, t.sd_m)) drifts_.push_back(*period);
        if (drifts_.size() > most_drifts) drifts_.pop_front();
    }
}

// Positions of two cameras are not compared: the drifts restart.
void WalkerMonitor::follow(const acquisition::TargetTrack& walker) {
    if (!camera_.empty()) {
        fold_ = reduction::PeriodFold{0, 1 / frequency_};
        drifts_.clear();
        edges_.clear();
        seen_ = walker.dropped + walker.tracks.size();
        lost_ = 0;
    }
    camera_ = walker.camera;
}

std::optional<double> WalkerMonitor::mean_edge_mm() const noexcept {
    if (edges_.empty()) return std::nullopt;
    double sum = 0;
    for (const Edge& e : edges_) sum += e.mm;
    return sum / static_cast<double>(edges_.size());
}

int WalkerMonitor::inwards() const noexcept {
    if (!x_m_ || !std::isfinite(ends_m_[0])) return 0;
    return *x_m_ < 0.5 * (ends_m_[0] + ends_m_[1]) ? 1 : -1;
}

bool WalkerMonitor::settled_since(double from_s, double gamma) const {
    std::vector<double> since;
    double sigma = 1e-4 * gamma / (two_pi * frequency_ * frequency_);
    for (const reduction::PeriodFold::Period& p : drifts_) {
        if ((p.k - 1) / frequency_ < from_s) continue;  // a drift spans two periods
        since.push_back(p.drift.value);
        sigma = std::max(sigma, p.drift.sigma);
    }
    return reduction::settled(since, sigma);
}

}  // namespace shaker::run
