#include "calibration/accelerometer/attitudes.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <boost/math/distributions/fisher_f.hpp>
#include <cmath>

#include "drivers/errors.hpp"

namespace shaker::calibration {

namespace {

constexpr std::size_t parts = 10, pieces = 5;
constexpr double part_dof = parts - 1, piece_dof = parts * (pieces - 1);
constexpr double chance = 1e-6;    // of refusing a record of a sensor at rest
constexpr double harmless = 5e-5;  // g, scatter of the parts' means that no attitude is refused for

// Variance of the parts' means, and what it would be if only the pieces' scatter were behind it.
struct Scatter {
    double mean, variance, expected;
};

Scatter scatter_of(std::span<const Counts> samples, std::size_t axis) {
    std::array<double, parts * pieces> piece{};
    const std::size_t size = samples.size() / piece.size();
    // The first sample as the origin: the sums stay exact.
    const auto origin = static_cast<double>(samples[0][axis]);
    for (std::size_t i = 0; i < size * piece.size(); ++i)
        piece[i / size] += (samples[i][axis] - origin) / static_cast<double>(size);
    std::array<double, parts> part{};
    double mean = 0, within = 0, between = 0;
    for (std::size_t i = 0; i < piece.size(); ++i) part[i / pieces] += piece[i] / pieces;
    for (const double m : part) mean += m / parts;
    for (std::size_t i = 0; i < piece.size(); ++i) within += std::pow(piece[i] - part[i / pieces], 2);
    for (const double m : part) between += std::pow(m - mean, 2);
    return {origin + mean, between / part_dof, within / piece_dof / pieces};
}

}  // namespace

Attitude attitude_of(std::string name, std::span<const Counts> samples) {
    if (samples.size() < fewest_samples)
        throw InputError{fmt::format("attitude \"{}\": {} samples; at least {} are required", name,
                                     samples.size(), fewest_samples)};
    Attitude attitude{.name = std::move(name)};
    for (std::size_t k = 0; k < 3; ++k) {
        const Scatter s = scatter_of(samples, k);
        attitude.mean[k] = s.mean;
        attitude.variance[k] = s.variance;
        attitude.expected[k] = s.expected;
    }
    return attitude;
}

std::string motion_in(const Attitude& attitude, const Vector& counts_per_g) {
    static const double limit =
        boost::math::quantile(boost::math::complement(boost::math::fisher_f{part_dof, piece_dof}, chance));
    for (std::size_t k = 0; k < 3; ++k) {
        const double wander_g = std::sqrt(attitude.variance[k]) / std::abs(counts_per_g[k]);
        if (wander_g < harmless || attitude.variance[k] < limit * attitude.expected[k]) continue;
        return fmt::format("the sensor moved: {} wanders by {:.2g} g, {:.2g} times its noise", "xyz"[k],
                           wander_g, std::sqrt(attitude.variance[k] / attitude.expected[k]));
    }
    return {};
}

std::string label_of(std::size_t index, const Attitude& attitude) {
    return attitude.name.empty() ? fmt::format("attitude {}", index + 1)
                                 : fmt::format("attitude {} ({})", index + 1, attitude.name);
}

std::string_view nearest_attitude(const Vector& direction) noexcept {
    return *std::ranges::max_element(standard_attitudes, {}, [&](std::string_view name) {
        const Vector up = *direction_of(name);
        return up[0] * direction[0] + up[1] * direction[1] + up[2] * direction[2];
    });
}

std::vector<std::string_view> missing_attitudes(std::span<const Vector> directions) {
    std::vector<std::string_view> missing;
    for (const std::string_view name : standard_attitudes) {
        const Vector up = *direction_of(name);
        bool held = false;
        for (const Vector& d : directions)
            held = held || up[0] * d[0] + up[1] * d[1] + up[2] * d[2] >
                               std::cos(same_attitude) * std::hypot(d[0], d[1], d[2]);
        if (!held) missing.push_back(name);
    }
    return missing;
}

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
