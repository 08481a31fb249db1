#include "daemon/run/walker_monitor.hpp"

#include <algorithm>
#include <utility>

#include "calibration/camera/camera_scale.hpp"
#include "drivers/drive.hpp"

namespace shaker::run {

namespace {

constexpr std::size_t most_drifts = 1000;  // a drift that settles needs fewer
constexpr double frames_missing = 10;
constexpr int newest_drifts = 5;

// Null when the streams have no such camera.
const acquisition::CameraStream* camera_of(const acquisition::TargetTrack& t,
                                           const acquisition::Streams& streams) {
    const auto camera = std::ranges::find(streams.cameras, t.camera,
                                          [](const acquisition::CameraStream& c) { return c.view.camera; });
    return camera != streams.cameras.end() ? &*camera : nullptr;
}

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

double extent_mm(const Target& target) { return std::max(target.diameter_mm, target.width_mm); }

// Distance of the outline from the nearer end of the picture, along the shaker's axis.
double edge_distance_mm(const tracking::Track& t, const Target& target,
                        const acquisition::CameraStream& camera) {
    const bool across = along_height(camera.view);
    const double at = across ? t.fix.y_px : t.fix.x_px, size = across ? camera.height : camera.width;
    return std::min(at, size - at) * camera.view.mm_per_px - 0.5 * extent_mm(target);
}

}  // namespace

// The followed camera as long as it sends pictures, else the first one that does.
const acquisition::TargetTrack* WalkerMonitor::choose(const acquisition::Streams& streams, double now_s,
                                                      double missing_s) {
    const acquisition::TargetTrack* chosen = nullptr;
    bool fresh = false, any = false;
    sources_.resize(streams.tracks.size());
    for (std::size_t i = 0; i < streams.tracks.size(); ++i) {
        const acquisition::TargetTrack& t = streams.tracks[i];
        if (t.target.name != "walker") continue;
        any = true;
        Source& source = sources_[i];
        const std::size_t taken = t.dropped + t.tracks.size();
        if (std::exchange(source.taken, taken) != taken) source.came_s = now_s;
        const acquisition::CameraStream* camera = camera_of(t, streams);
        if (camera != nullptr && !camera->failure.empty()) continue;
        const double rate_hz = camera != nullptr ? camera->view.frame_rate_hz : 0;
        const double most_s = rate_hz > 0 ? std::max(missing_s, frames_missing / rate_hz) : missing_s;
        const bool sends = now_s - source.came_s <= most_s;
        if (chosen != nullptr && sends <= fresh && (sends != fresh || t.camera != camera_)) continue;
        chosen = &t;
        fresh = sends;
        age_s_ = now_s - source.came_s;
        most_age_s_ = most_s;
    }
    watches_ = chosen != nullptr;
    blind_ = any && !watches_;
    if (!fresh) forget_place();
    return chosen;
}

void WalkerMonitor::add(const acquisition::Streams& streams, double now_s, double missing_s) {
    const acquisition::TargetTrack* walker = choose(streams, now_s, missing_s);
    found_age_s_ = now_s - found_s_;
    if (walker == nullptr) return;
    const acquisition::CameraStream* camera = camera_of(*walker, streams);
    if (walker->camera != camera_) follow(*walker);
    seen_ = std::max(seen_, walker->dropped);
    for (; seen_ < walker->dropped + walker->tracks.size(); ++seen_) {
        const tracking::Track& t = walker->tracks[seen_ - walker->dropped];
        const bool doubted = doubtful(t.fix.state);
        const double doubt_mm = doubted ? 2e3 * t.sd_m : 0;
        const bool shown = found(t.fix.state) && (!doubted || camera == nullptr || camera->width == 0 ||
                                                  doubt_mm < edge_distance_mm(t, walker->target, *camera));
        lost_ = shown ? 0 : lost_ + 1;
        if (!std::isfinite(seconds(t.time))) continue;
        until_s_ = std::max(until_s_, seconds(t.time));
        if (!found(t.fix.state)) continue;
        found_s_ = now_s;
        found_age_s_ = 0;
        x_m_ = t.x_m;
        if (camera != nullptr && camera->width > 0) {
            const double edge_mm = edge_distance_mm(t, walker->target, *camera);
            edge_mm_ = edge_mm - doubt_mm;
            edges_.push_back({seconds(t.time), edge_mm, t.x_m});
            half_mm_ = 0.5 * extent_mm(walker->target);
            while (edges_.front().at_s <= edges_.back().at_s - 1 / frequency_) edges_.pop_front();
            ends_m_ = picture_ends_m(t, walker->target, *camera);
        }
        if (const auto period = fold_.add(seconds(t.time), t.x_m, t.sd_m)) drifts_.push_back(*period);
        if (drifts_.size() > most_drifts) drifts_.pop_front();
    }
}

void WalkerMonitor::dac_was_silent(double silent_s, double now_s) noexcept {
    for (Source& s : sources_) s.came_s = std::min(s.came_s + silent_s, now_s);
    found_s_ = std::min(found_s_ + silent_s, now_s);
}

// Positions of two cameras are not compared: the drifts restart.
void WalkerMonitor::follow(const acquisition::TargetTrack& walker) {
    if (!camera_.empty()) {
        set_frequency(frequency_);
        forget_place();
        const std::size_t newest = walker.tracks.empty() ? 0 : 1;
        seen_ = walker.dropped + walker.tracks.size() - newest;
        lost_ = 0;
    }
    camera_ = walker.camera;
}

void WalkerMonitor::set_frequency(double frequency) {
    frequency_ = frequency;
    fold_ = reduction::PeriodFold{0, 1 / frequency};
    drifts_.clear();
}

void WalkerMonitor::forget_place() noexcept {
    x_m_.reset();
    edge_mm_.reset();
    edges_.clear();
    ends_m_ = {NAN, NAN};
    found_s_ = -INFINITY;
}

std::optional<double> WalkerMonitor::mean_edge_mm() const noexcept {
    if (edges_.empty()) return std::nullopt;
    double sum = 0;
    for (const Edge& e : edges_) sum += e.mm;
    return sum / static_cast<double>(edges_.size());
}

std::array<double, 2> WalkerMonitor::ways_m(double edge_mm) const noexcept {
    if (edges_.empty() || !std::isfinite(ends_m_[0])) return {NAN, NAN};
    double sum_m = 0;
    for (const Edge& e : edges_) sum_m += e.x_m;
    const double x_m = sum_m / static_cast<double>(edges_.size());
    const auto [low_m, high_m] = std::minmax(ends_m_[0], ends_m_[1]);
    const double inside_m = 1e-3 * (half_mm_ + edge_mm);
    return {x_m - low_m - inside_m, high_m - x_m - inside_m};
}

double WalkerMonitor::swing_m() const noexcept {
    if (edges_.empty()) return 0;
    const auto [least, most] = std::ranges::minmax(edges_, {}, &Edge::x_m);
    return (most.x_m - least.x_m) / 2;
}

int WalkerMonitor::inwards() const noexcept {
    if (!x_m_ || !std::isfinite(ends_m_[0])) return 0;
    return *x_m_ < 0.5 * (ends_m_[0] + ends_m_[1]) ? 1 : -1;
}

std::optional<double> WalkerMonitor::drift_m() const noexcept {
    double sum = 0;
    int count = 0;
    for (auto p = drifts_.rbegin(); p != drifts_.rend() && count < newest_drifts; ++p) {
        if (!std::isfinite(p->drift.value)) break;
        sum += p->drift.value;
        ++count;
    }
    return count > 0 ? std::optional{sum / count} : std::nullopt;
}

bool WalkerMonitor::settled_since(double from_s, double gamma) const {
    std::vector<double> since;
    double sigma = 3e-5 * gamma / (two_pi * frequency_ * frequency_);
    for (const reduction::PeriodFold::Period& p : drifts_) {
        if ((p.k - 1) / frequency_ < from_s) continue;  // a drift spans two periods
        since.push_back(p.drift.value);
        sigma = std::max(sigma, p.drift.sigma);
    }
    return reduction::settled(since, sigma);
}

double periods_to_edge(const std::array<double, 2>& ways_m, double walk_m, double swing_m) noexcept {
    const double way_m = ways_m.at(walk_m < 0 ? 0 : 1) - swing_m;
    return way_m <= 0 ? 0 : way_m / std::abs(walk_m);
}

}  // namespace shaker::run
