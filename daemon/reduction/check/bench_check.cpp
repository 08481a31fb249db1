#include "daemon/reduction/check/bench_check.hpp"

#include <spdlog/fmt/fmt.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <boost/math/special_functions/sinc.hpp>
#include <cmath>
#include <numbers>

#include "calibration/accelerometer/transverse.hpp"
#include "drivers/drive.hpp"
#include "drivers/errors.hpp"
#include "drivers/walker/steady_state.hpp"

namespace shaker::reduction {

namespace {

constexpr double alarm = 4;                             // standard errors
constexpr double tracker_bias = 1e-4;                   // of a ratio: trackers prefer positions in a pixel
constexpr double same_response = 1e-3;                  // ratios at w and 2w that agree well enough
constexpr double bad_residuals = 0.05, bad_tracks = 3;  // of gamma; of the trackers' standard deviations

/// Covariance of ln |a_q| and ln |a_p|.
double log_covariance(const calibration::HarmonicFit& fit, int q, int p) {
    const std::complex<double> a = fit.at(q) / std::norm(fit.at(q)), b = fit.at(p) / std::norm(fit.at(p));
    const int i = 2 * (q - 1), j = 2 * (p - 1);
    return a.real() * (b.real() * fit.cov(i, j) + b.imag() * fit.cov(i, j + 1)) +
           a.imag() * (b.real() * fit.cov(i + 1, j) + b.imag() * fit.cov(i + 1, j + 1));
}

/// ln of the ratios, with their covariance.
struct Logs {
    Eigen::VectorXd y;
    Eigen::MatrixXd covariance;
};

/// Weighted least squares of rows of `logs`; the first unknown with its standard error.
calibration::Estimate first_unknown(const Logs& logs, const Eigen::MatrixXd& X,
                                    const std::vector<Eigen::Index>& rows) {
    const Eigen::MatrixXd C = logs.covariance(rows, rows);
    const Eigen::LDLT<Eigen::MatrixXd> solve(C);
    const Eigen::MatrixXd CX = solve.solve(X);
    const Eigen::MatrixXd inverse = (X.transpose() * CX).inverse();
    const Eigen::VectorXd p = inverse * (CX.transpose() * logs.y(rows));
    return {p(0), std::sqrt(inverse(0, 0))};
}

calibration::Estimate exponential(const calibration::Estimate& e) {
    return {std::exp(e.value), std::exp(e.value) * e.sigma};
}

Logs compare(const calibration::HarmonicFit& acceleration, std::span<const SeenBase> views, GainRatio& out) {
    const double w = two_pi * acceleration.frequency_hz;
    std::vector<double> y;
    for (std::size_t v = 0; v < views.size(); ++v) {
        const calibration::HarmonicFit& position = views[v].position;
        for (int q = 1; q <= std::min({position.order(), acceleration.order(), 2}); ++q) {
            if (!position.stands_out(q) || !acceleration.stands_out(q)) continue;
            const double qw = q * w;
            const auto turn = std::polar(1.0, qw * (acceleration.origin_s - position.origin_s));
            const auto r = -qw * qw * position.at(q) * turn / acceleration.at(q) /
                           boost::math::sinc_pi(w / 2 * q * views[v].exposure_s);
            const double relative =
                std::sqrt(log_covariance(position, q, q) + log_covariance(acceleration, q, q));
            out.at.push_back(
                {static_cast<int>(v),
                 q,
                 {std::abs(r), std::abs(r) * relative},
                 {-std::arg(r) / qw, std::hypot(position.phase_sd(q), acceleration.phase_sd(q)) / qw}});
            y.push_back(std::log(std::abs(r)));
        }
    }
    const auto n = std::ssize(y);
    Logs logs{Eigen::Map<Eigen::VectorXd>(y.data(), n), Eigen::MatrixXd(n, n)};
    for (Eigen::Index i = 0; i < n; ++i)
        for (Eigen::Index j = 0; j < n; ++j) {
            const RatioAt &a = out.at[static_cast<std::size_t>(i)], &b = out.at[static_cast<std::size_t>(j)];
            logs.covariance(i, j) = log_covariance(acceleration, a.q, b.q);
            if (a.view == b.view)
                logs.covariance(i, j) +=
                    log_covariance(views[static_cast<std::size_t>(a.view)].position, a.q, b.q);
        }
    return logs;
}

std::vector<Eigen::Index> rows_of(const GainRatio& check, int view) {
    std::vector<Eigen::Index> rows;
    for (std::size_t i = 0; i < check.at.size(); ++i)
        if (check.at[i].view == view) rows.push_back(static_cast<Eigen::Index>(i));
    return rows;
}

/// Ratio at 2w over that at w; each view has its own gain.
calibration::Estimate second_over_first(const GainRatio& check, const Logs& logs, int views) {
    const bool both = std::ranges::any_of(check.at, [](const RatioAt& r) { return r.q == 1; }) &&
                      std::ranges::any_of(check.at, [](const RatioAt& r) { return r.q == 2; });
    std::vector<Eigen::Index> rows;
    int with_both = 0;
    for (int v = 0; v < views; ++v) {
        const std::vector<Eigen::Index> of = rows_of(check, v);
        if (of.size() < 2) continue;
        rows.insert(rows.end(), of.begin(), of.end());
        ++with_both;
    }
    if (!both || rows.empty()) return {};
    Eigen::MatrixXd X = Eigen::MatrixXd::Zero(std::ssize(rows), with_both + 1);
    for (Eigen::Index i = 0; i < X.rows(); ++i) {
        X(i, 0) = check.at[static_cast<std::size_t>(rows[static_cast<std::size_t>(i)])].q == 2 ? 1 : 0;
        X(i, 1 + i / 2) = 1;
    }
    return exponential(first_unknown(logs, X, rows));
}

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

GainRatio gain_ratio(const calibration::HarmonicFit& acceleration, std::span<const SeenBase> views,
                     double gain_error) {
    GainRatio out;
    const Logs logs = compare(acceleration, views, out);
    if (out.at.empty()) return out;
    const auto mean = [&](const std::vector<Eigen::Index>& rows) {
        return exponential(first_unknown(logs, Eigen::MatrixXd::Ones(std::ssize(rows), 1), rows));
    };
    std::vector<Eigen::Index> all;
    double scale = 0, weight = 0;
    for (std::size_t v = 0; v < views.size(); ++v) {
        const std::vector<Eigen::Index> rows = rows_of(out, static_cast<int>(v));
        if (rows.empty()) continue;
        all.insert(all.end(), rows.begin(), rows.end());
        const ViewRatio& seen =
            out.views.emplace_back(ViewRatio{views[v].view, mean(rows), views[v].scale_error});
        const double w = 1 / (seen.ratio.sigma * seen.ratio.sigma);
        scale += w * seen.scale_error;
        weight += w;
    }
    out.ratio = mean(all);
    out.second_over_first = second_over_first(out, logs, static_cast<int>(views.size()));
    if (const double known = std::hypot(scale / weight, gain_error); known > 0) out.systematic = known;
    return out;
}

namespace {

/// The instrument to suspect for a view that disagrees, and what to do.
struct Suspect {
    std::string who, remedy;
};

Suspect suspect(const calibration::HarmonicFit& acceleration, const SeenBase& seen, bool others_agree,
                double gain_error) {
    const double gamma =
        std::abs(acceleration.at(1)) + (acceleration.order() > 1 ? std::abs(acceleration.at(2)) : 0);
    const std::string of_scale = fmt::format("measure mm_per_px and offset_mm of camera \"{}\"", seen.view),
                      of_gain = "calibrate the accelerometer (\"shakerd calibrate accelerometer\")";
    const bool sensor = acceleration.rms > bad_residuals * gamma,
               tracks = seen.position.stream_rms.front() > bad_tracks;
    if (sensor && !tracks)
        return {
            fmt::format("sensor gain (its residuals are {:.1f} % of gamma)", 100 * acceleration.rms / gamma),
            "check the accelerometer's mounting and cable"};
    if (tracks && !sensor)
        return {fmt::format("camera scale (the tracks' residuals are {:.1f} times their standard deviation)",
                            seen.position.stream_rms.front()),
                "check the base's target and its light"};
    if (others_agree) return {"camera scale (the other views agree with the accelerometer)", of_scale};
    if (gain_error > 0 && !(seen.scale_error > 0))
        return {"camera scale (the accelerometer is calibrated)", of_scale};
    if (seen.scale_error > 0 && !(gain_error > 0))
        return {"sensor gain (the camera's scale is calibrated)", of_gain};
    return {"camera scale or sensor gain", of_gain + ", then " + of_scale};
}

}  // namespace

std::string scale_cause(double ratio) {
    struct Factor {
        double value;
        const char* cause;
    };
    constexpr std::array factors{
        Factor{10, "10 (or 1/10) is often the gain of a conditioner that the settings lack"},
        Factor{100, "100 (or 1/100) is often the gain of a conditioner that the settings lack"},
        Factor{std::numbers::sqrt2,
               "1.414 (or its inverse) is often a full_scale_V in rms volts instead of peak volts"},
        Factor{2, "2 (or 1/2) is often a balanced input of which one line is connected"},
        Factor{
            9.80665,
            "9.81 (or its inverse) is often a sensitivity per m/s^2 that was entered per g, or the reverse"}};
    constexpr double alike = 0.01;
    for (const Factor& f : factors)
        if (std::abs(ratio / f.value - 1) < alike || std::abs(ratio * f.value - 1) < alike)
            return fmt::format("; a factor of {}", f.cause);
    return {};
}

void note_gain(GainRatio& check, const calibration::HarmonicFit& acceleration,
               std::span<const SeenBase> views, double gain_error, std::vector<std::string>& notes) {
    const auto error_of = [&](const ViewRatio& v) {
        return std::hypot(std::hypot(v.ratio.sigma / v.ratio.value, tracker_bias), v.scale_error, gain_error);
    };
    const auto disagrees = [&](const ViewRatio& v) {
        return std::abs(std::log(v.ratio.value)) > alarm * error_of(v);
    };
    const std::size_t before = notes.size();
    const bool some_agree = !std::ranges::all_of(check.views, disagrees);
    for (const ViewRatio& v : check.views) {
        if (!disagrees(v)) continue;
        const SeenBase& seen = *std::ranges::find(views, v.view, &SeenBase::view);
        const auto [who, remedy] = suspect(acceleration, seen, some_agree, gain_error);
        const std::string known =
            v.scale_error > 0 || gain_error > 0
                ? fmt::format("{:.2g} % of it systematic", 100 * std::hypot(v.scale_error, gain_error))
                : "no systematic error is known";
        notes.push_back(fmt::format(
            "{}base's acceleration by camera \"{}\" is {:.5f} times that by the "
            "accelerometer, "
            "{:.0f} standard errors from 1 (one is {:.2g} %; {}): {} is off by {:.2f} %; v_D has "
            "the camera's "
            "scale, gamma the accelerometer's; {}{}",
            alarm_note, v.view, v.ratio.value, std::abs(std::log(v.ratio.value)) / error_of(v),
            100 * error_of(v), known, who, 100 * (v.ratio.value - 1), remedy, scale_cause(v.ratio.value)));
    }
    const calibration::Estimate& r = check.second_over_first;
    if (std::abs(r.value - 1) > std::max(alarm * r.sigma, same_response))
        notes.push_back(fmt::format(
            "{}ratio of cameras to accelerometer at 2w is {:.5f} +- {:.5f} times that at w, "
            "which no gain explains: check exposure_s, the accelerometer's filter and its mounting",
            alarm_note, r.value, r.sigma));
    check.alarm = notes.size() > before;
}

void note_corner(const Corner& corner, double frequency_hz, std::vector<std::string>& notes) {
    if (corner.alarm)
        notes.push_back(fmt::format(
            "{}phase phi by the cameras is {:+.2f} +- {:.2f} mrad off that by the accelerometer, and no "
            "delay "
            "explains it: check the accelerometer's lower corner, its low-pass and its mounting; {}",
            alarm_note, 1e3 * corner.phi_off.value, 1e3 * corner.phi_off.sigma,
            std::isnan(corner.hz.value) ? "phi, mu and the law of friction are by the accelerometer"
                                        : "phi, mu and the law of friction are by the cameras"));
    if (corner.unknown)  // one pole: the phase of harmonic q leads by corner / (q f)
        notes.push_back(fmt::format(
            "{}, which no camera shows: 0.1 Hz of it turn phi by {:.2g} mrad, and mu and the law of friction "
            "depend on it",
            corner_note, 1e3 * 1.5 * 0.1 / frequency_hz));
    if (corner.large)
        notes.push_back(
            fmt::format("the accelerometer's lower corner, {:.3g} Hz, lowers the drive's first harmonic by "
                        "more than 10 %: {}",
                        corner.hz.value, degraded_note));
}

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
