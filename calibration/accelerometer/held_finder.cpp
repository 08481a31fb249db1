#include "calibration/accelerometer/held_finder.hpp"

#include <algorithm>
#include <cmath>

namespace shaker::calibration {

HeldFinder::HeldFinder(double rate_hz, double hold_s, const Vector& nominal, double gravity)
    : nominal_{nominal},
      size_{std::max(fewest_samples, static_cast<std::size_t>(std::llround(rate_hz * hold_s)))} {
    for (std::size_t k = 0; k < 3; ++k) counts_per_g_[k] = gravity / nominal[k];
    record_.reserve(size_);
}

bool HeldFinder::turned_to(const Vector& mean) {
    Vector up{};
    for (std::size_t k = 0; k < 3; ++k) up[k] = mean[k] * nominal_[k];
    const double length = std::hypot(up[0], up[1], up[2]);
    for (double& x : up) x /= length;
    const bool first = !before_;
    const Vector last = before_.value_or(up);
    if (!first && up[0] * last[0] + up[1] * last[1] + up[2] * last[2] > std::cos(same_attitude)) return false;
    before_ = up;
    return !first;
}

std::optional<Attitude> HeldFinder::add(const Counts& sample) {
    record_.push_back(sample);
    if (record_.size() < size_) return std::nullopt;
    Attitude attitude = attitude_of("", record_);
    why_not_ = motion_in(attitude, counts_per_g_);
    if (why_not_.empty() && turned_to(attitude.mean)) {
        found_.swap(record_);
        record_.clear();
        return attitude;
    }
    if (why_not_.empty()) why_not_ = "the sensor has not been turned";
    record_.erase(record_.begin(), record_.begin() + static_cast<std::ptrdiff_t>(size_ / 10));
    return std::nullopt;
}

}  // namespace shaker::calibration
