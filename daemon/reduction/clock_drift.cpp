#include "daemon/reduction/clock_drift.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "daemon/reduction/spread/drift_spread.hpp"
#include "drivers/drive.hpp"

namespace shaker::reduction {
namespace {

constexpr double least_periods = 4;
constexpr std::size_t fewest_windows = 6;

calibration::HarmonicFit velocity_of(calibration::HarmonicFit fit) {
    for (int q = 1; q <= fit.order(); ++q)
        fit.a[static_cast<std::size_t>(q - 1)] *= std::complex<double>(0, two_pi * fit.frequency_hz * q);
    return fit;
}

/// Sums over one stream's samples in one window for residual = c - delay derivative.
struct WindowSums {
    double weight = 0, d = 0, dd = 0, r = 0, dr = 0;
    std::size_t samples = 0;
    [[nodiscard]] double information() const { return dd - d * d / weight; }
    [[nodiscard]] double right() const { return -(dr - d * r / weight); }
};

/// Adds a stream's samples to the windows from from_s on.
std::vector<WindowSums> window_sums(const calibration::HarmonicFit& fit, double constant,
                                    const calibration::HarmonicSamples& in, double scale, double from_s,
                                    double window_s, std::size_t windows) {
    std::vector<WindowSums> out(windows);
    std::vector<double> model(in.t.size()), slope(in.t.size());
    fit.periodic(in.t, model);
    velocity_of(fit).periodic(in.t, slope);
    for (std::size_t i = 0; i < in.t.size(); ++i) {
        const double at = (in.t[i] - from_s) / window_s;
        if (!(at >= 0 && at < static_cast<double>(windows))) continue;
        WindowSums& s = out[static_cast<std::size_t>(at)];
        const double sd = scale * (in.sd.empty() ? 1.0 : in.sd[i]), w = 1 / (sd * sd);
        const double r = in.y[i] - constant - model[i], d = slope[i];
        s.weight += w;
        s.d += w * d;
        s.dd += w * d * d;
        s.r += w * r;
        s.dr += w * d * r;
        ++s.samples;
    }
    return out;
}

/// Delays by streams of one kind. Windows with few samples have an infinite error.
std::vector<calibration::Estimate> combined(const std::vector<std::vector<WindowSums>>& streams) {
    std::vector<calibration::Estimate> out;
    std::size_t most = 0;
    for (const auto& stream : streams)
        for (const WindowSums& s : stream) most = std::max(most, s.samples);
    for (std::size_t k = 0; k < streams.front().size(); ++k) {
        double information = 0, right = 0;
        for (const auto& stream : streams) {
            if (2 * stream[k].samples < most) continue;
            information += stream[k].information();
            right += stream[k].right();
        }
        out.push_back({right / information, 1 / std::sqrt(information)});
    }
    return out;
}

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

/// Delays with line and walk of a given strength: walk variance `strength` a second, in units of the white
/// variance's scale.
struct Model {
    Matrix X;     // 1, t - middle
    Matrix walk;  // covariance of a walk of strength 1
    Vector d, variance;
};

struct Fitted {
    Eigen::LLT<Matrix> covariance;
    Eigen::Matrix2d information;  // of the line
    Eigen::Vector2d line;
    Vector weighted;         // C^-1 (d - X line)
    double scale2 = 1;       // of all variances
    double minus_2_log = 0;  // of the restricted likelihood
};

Fitted fit(const Model& m, double strength, WindowScatter scatter) {
    Fitted f;
    Matrix C = strength * m.walk;
    C.diagonal() += m.variance;
    f.covariance.compute(C);
    const Matrix CX = f.covariance.solve(m.X);
    f.information = m.X.transpose() * CX;
    f.line = f.information.ldlt().solve(CX.transpose() * m.d);
    const Vector left = m.d - m.X * f.line;
    f.weighted = f.covariance.solve(left);
    const double squares = left.dot(f.weighted), freedom = static_cast<double>(m.d.size() - 2);
    f.scale2 = scatter == WindowScatter::free ? std::max(1.0, squares / freedom) : 1.0;
    f.minus_2_log = freedom * std::log(f.scale2) + squares / f.scale2 +
                    2 * f.covariance.matrixLLT().diagonal().array().log().sum() +
                    std::log(f.information.determinant());
    return f;
}

Model model_of(const std::vector<WindowDelay>& windows, double middle_s) {
    const auto n = static_cast<Eigen::Index>(windows.size());
    Model m{Matrix(n, 2), Matrix(n, n), Vector(n), Vector(n)};
    for (Eigen::Index i = 0; i < n; ++i) {
        const WindowDelay& w = windows[static_cast<std::size_t>(i)];
        m.X.row(i) << 1, w.t_s - middle_s;
        m.d(i) = w.delay_s.value;
        m.variance(i) = w.delay_s.sigma * w.delay_s.sigma;
        for (Eigen::Index j = 0; j <= i; ++j)
            m.walk(i, j) = m.walk(j, i) = windows[static_cast<std::size_t>(j)].t_s - windows.front().t_s;
    }
    return m;
}

}  // namespace

std::vector<WindowDelay> WindowDelays::differences() const {
    std::vector<WindowDelay> out;
    for (std::size_t k = 0; k < sensor.size(); ++k) {
        const calibration::Estimate &a = sensor[k].delay_s, &b = cameras[k].delay_s;
        out.push_back({sensor[k].t_s, {a.value - b.value, std::hypot(a.sigma, b.sigma)}});
    }
    return out;
}

WindowDelays delays_in_windows(std::span<const MotionSeries> bases, const calibration::HarmonicFit& base,
                               std::span<const double> t_s, std::span<const double> along_mps2,
                               const calibration::HarmonicFit& acceleration, int most) {
    const double from = t_s.front(), span = t_s.back() - from;
    const double periods = span * base.frequency_hz;
    const auto windows =
        static_cast<std::size_t>(std::clamp(periods / least_periods, 0.0, static_cast<double>(most)));
    if (windows < fewest_windows) return {};
    const double window_s = span / static_cast<double>(windows);
    std::vector<std::vector<WindowSums>> cameras;
    for (std::size_t v = 0; v < bases.size(); ++v)
        cameras.push_back(window_sums(base, base.constants[v], {bases[v].t_s, bases[v].x_m, bases[v].sd_m},
                                      std::max(base.stream_rms[v], 1e-6), from, window_s, windows));
    const auto by_camera = combined(cameras);
    const auto by_sensor =
        combined({window_sums(acceleration, acceleration.constants[0], {t_s, along_mps2, {}},
                              std::max(acceleration.rms, 1e-12), from, window_s, windows)});
    WindowDelays out;
    for (std::size_t k = 0; k < windows; ++k) {
        const calibration::Estimate &a = by_sensor[k], &b = by_camera[k];
        if (!std::isfinite(a.value + a.sigma + b.value + b.sigma)) continue;
        const double middle = from + (static_cast<double>(k) + 0.5) * window_s;
        out.sensor.push_back({middle, a});
        out.cameras.push_back({middle, b});
    }
    return out;
}

double unconfirmed_walk(const WindowDelays& delays) {
    if (delays.sensor.size() < fewest_windows) return 0;
    const double middle = delays.sensor[delays.sensor.size() / 2].t_s;
    const ClockDrift sensor = drift_of(delays.sensor, middle, WindowScatter::as_stated);
    if (!sensor.significant()) return 0;
    // Fit of the cameras' delays: line, and share of the sensor's.
    const Model cameras = model_of(delays.cameras, middle);
    Matrix X(cameras.X.rows(), 3);
    X.leftCols(2) = cameras.X;
    for (Eigen::Index i = 0; i < X.rows(); ++i)
        X(i, 2) = delays.sensor[static_cast<std::size_t>(i)].delay_s.value;
    const Vector weight = cameras.variance.cwiseInverse();
    const Eigen::Matrix3d covariance = (X.transpose() * weight.asDiagonal() * X).inverse();
    const Eigen::Vector3d p = covariance * (X.transpose() * weight.asDiagonal() * cameras.d);
    if (p(2) > 3 * std::sqrt(covariance(2, 2))) return 0;
    return sensor.walk_s_rts * few_periods_factor(static_cast<int>(delays.sensor.size()) - 2);
}

bool ClockDrift::scatters() const noexcept {
    if (t_s.empty()) return false;
    return scatter * scatter > 1 + 4 * std::sqrt(2 / static_cast<double>(t_s.size() - 2));
}

double ClockDrift::farthest_from_line(double middle) const noexcept {
    double farthest = 0;
    for (std::size_t i = 0; i < t_s.size(); ++i)
        farthest = std::max(farthest, std::abs(delay_s[i] - middle_s.value - rate.value * (t_s[i] - middle)));
    return farthest;
}

double ClockDrift::at(double t) const noexcept {
    if (t_s.empty()) return 0;
    if (t <= t_s.front()) return delay_s.front() + rate.value * (t - t_s.front());
    if (t >= t_s.back()) return delay_s.back() + rate.value * (t - t_s.back());
    const auto after = std::ranges::upper_bound(t_s, t) - t_s.begin();
    const auto i = static_cast<std::size_t>(after);
    const double share = (t - t_s[i - 1]) / (t_s[i] - t_s[i - 1]);
    return delay_s[i - 1] + share * (delay_s[i] - delay_s[i - 1]);
}

ClockDrift drift_of(const std::vector<WindowDelay>& windows, double middle_s, WindowScatter scatter) {
    ClockDrift out;
    if (windows.size() < fewest_windows) return out;
    const Model m = model_of(windows, middle_s);
    const Fitted line = fit(m, 0, scatter);
    const double step = (windows.back().t_s - windows.front().t_s) / static_cast<double>(windows.size() - 1);
    const double usual = m.variance.mean() / step;  // the walk of a window is as large as its error
    double strength = 0;
    Fitted best = line;
    for (double s = 1e-5 * usual; s < 1e7 * usual; s *= 2.5) {
        Fitted f = fit(m, s, scatter);
        if (f.minus_2_log >= best.minus_2_log) continue;
        best = std::move(f);
        strength = s;
    }
    out.likelihood_ratio = line.minus_2_log - best.minus_2_log;
    out.scatter = std::sqrt(line.scale2);
    out.walk_s_rts = std::sqrt(strength * best.scale2);
    const Vector delays = m.X * best.line + strength * m.walk * best.weighted;
    for (std::size_t i = 0; i < windows.size(); ++i) out.t_s.push_back(windows[i].t_s);
    out.delay_s.assign(delays.begin(), delays.end());
    const Eigen::Matrix2d line_covariance = best.scale2 * best.information.inverse();
    out.rate = {best.line(1), std::sqrt(line_covariance(1, 1))};
    // Kriging of the middle.
    const double age = middle_s - windows.front().t_s;
    Vector k(m.d.size());
    for (Eigen::Index i = 0; i < k.size(); ++i)
        k(i) = strength * std::min(age, windows[static_cast<std::size_t>(i)].t_s - windows.front().t_s);
    const Vector Ck = best.covariance.solve(k);
    const Eigen::Vector2d x = Eigen::Vector2d(1, 0) - m.X.transpose() * Ck;
    const double variance = best.scale2 * (strength * age - k.dot(Ck)) + x.dot(line_covariance * x);
    out.middle_s = {out.at(middle_s), std::sqrt(std::max(variance, 0.0))};
    return out;
}

}  // namespace shaker::reduction
