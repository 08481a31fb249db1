#include "daemon/reduction/check/tilt.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "calibration/accelerometer/transverse.hpp"
#include "drivers/drive.hpp"
#include "drivers/errors.hpp"
#include "drivers/walker/steady_state.hpp"

namespace shaker::reduction {
namespace {

constexpr double least_gravity = 9, most_gravity = 10.6;  // m/s^2
constexpr double sliding = 0.1;                           // of the largest v_R
constexpr double of_share = 0.1;                          // error of the law and of mu
constexpr double farthest_from_law = 0.1;                 // of gamma/omega

double error_of_mean(const calibration::HarmonicFit& fit) {
    return fit.rms / std::sqrt(static_cast<double>(fit.samples));
}

/// Standard error of the axis' direction in a plane through it, rad: by the noise across it.
double axis_error(const SensorFits& s) {
    double signal = 0, noise = 0;
    for (int q = 1; q <= std::min(s.along->order(), 2); ++q) {
        signal += std::norm(s.along->at(q));
        for (const calibration::HarmonicFit* fit : s.across)
            for (const int i : {2 * (q - 1), 2 * (q - 1) + 1}) noise = std::max(noise, fit->cov(i, i));
    }
    return std::sqrt(noise / signal);
}

}  // namespace

Tilt tilt_of(const SensorFits& s) {
    Tilt out;
    const std::array means{s.along->constants[0], s.across[0]->constants[0], s.across[1]->constants[0]};
    const double g = std::hypot(means[0], means[1], means[2]);
    if (!(g > least_gravity && g < most_gravity)) return out;
    const double across = std::hypot(means[1], means[2]);
    out.angle.value = -std::atan2(means[0], across);
    out.noise = error_of_mean(*s.along) / g;
    if (s.axis_from_motion) out.noise = std::hypot(out.noise, axis_error(s));
    if (s.calibration == nullptr || !*s.calibration) return out;
    const auto axes = calibration::across_axes(s.axis);
    calibration::Vector reading{};
    for (std::size_t k = 0; k < 3; ++k)
        reading[k] = means[0] * s.axis[k] + means[1] * axes[0][k] + means[2] * axes[1][k];
    out.angle.sigma = std::hypot(out.noise, (*s.calibration)->reading_error(s.axis, reading) / across);
    return out;
}

double friction_in_slip(std::span<const double> phase, std::span<const double> v,
                        std::span<const double> v_base, double frequency_hz) {
    double largest = 0;
    for (std::size_t i = 0; i < v.size(); ++i) largest = std::max(largest, std::abs(v[i] - v_base[i]));
    std::vector<double> slopes;
    for (std::size_t i = 1; i + 1 < v.size(); ++i) {
        const double relative = v[i] - v_base[i];
        if (!(std::abs(relative) > sliding * largest)) continue;
        const double slope = (v[i + 1] - v[i - 1]) * frequency_hz / (phase[i + 1] - phase[i - 1]);
        slopes.push_back(relative > 0 ? -slope : slope);
    }
    if (slopes.size() < 4) return NAN;
    const auto middle = slopes.begin() + std::ssize(slopes) / 2;
    std::ranges::nth_element(slopes, middle);
    return *middle > 0 ? *middle / paper_g : NAN;
}

void set_share(Tilt& tilt, const calibration::HarmonicFit& acceleration, double mu, double v_D) try {
    if (!std::isfinite(mu) || !std::isfinite(tilt.angle.value)) return;
    walker::WalkerSetting setting{.frequency = acceleration.frequency_hz};
    setting.friction.mu_k = setting.friction.mu_s = mu;
    double gamma = 0;
    for (int q = 1; q <= std::min(acceleration.order(), max_harmonics); ++q)
        setting.base.at(q) = acceleration.at(q);
    for (int q = 1; q <= std::min(acceleration.order(), 2); ++q) gamma += std::abs(acceleration.at(q));
    const auto drift = [&](double angle) {
        setting.tilt = angle;
        return settle(walker::WalkerLaw{setting}).v_D;
    };
    const double angle = tilt.angle.value, here = drift(angle);
    if (!(std::abs(here - v_D) * two_pi * acceleration.frequency_hz < farthest_from_law * gamma)) return;
    const double share = here - drift(0);
    tilt.mu = mu;
    tilt.v_D = {share, NAN};
    if (!std::isfinite(tilt.angle.sigma)) return;
    const double by_angle = (drift(angle + tilt.angle.sigma) - drift(angle - tilt.angle.sigma)) / 2;
    tilt.v_D.sigma = std::hypot(by_angle, of_share * share);
} catch (const InputError&) {
    // No settled motion under this law: the share stays unknown.
}

}  // namespace shaker::reduction
