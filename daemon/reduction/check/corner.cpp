#include "daemon/reduction/check/corner.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <boost/math/special_functions/sinc.hpp>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>

#include "calibration/harmonics/harmonic_gradients.hpp"
#include "drivers/drive.hpp"

namespace shaker::reduction {

namespace {

constexpr double agreeing = 4;         // standard errors
constexpr double most_lowered = 0.1;   // of an amplitude
constexpr double bias_of_phi = 1e-4;   // rad: trackers
constexpr double bias_without = 3e-4;  // rad: also a low-pass of 500 Hz that nobody stated
constexpr double bias_of_rise = 2e-4;  // of the ratio of two amplitudes: trackers, exposure

using calibration::covariance_of;
using calibration::HarmonicFit;
using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

/// By how much the accelerometer leads the cameras.
struct Leads {
    std::vector<int> q{};
    Vector rad;
    Matrix by_sensor;                  // derivative by the accelerometer's harmonics
    Matrix cameras;                    // covariance by the cameras' noise
    calibration::Estimate log_rise{};  // ln of the ratio accelerometer / cameras at 2w over that at w
    [[nodiscard]] bool both() const { return q.size() >= 2 && q[0] == 1 && q[1] == 2; }
};

Leads leads_of(const HarmonicFit& sensor, const HarmonicFit& cameras, double exposure_s) {
    constexpr double most = 3.5;  // harmonics
    std::vector<calibration::ResponseLine> lines = lines_of(sensor, cameras, exposure_s);
    std::erase_if(lines, [&](const auto& line) { return line.hz > most * sensor.frequency_hz; });
    Leads out;
    const auto n = std::ssize(lines);
    out.rad.resize(n);
    out.by_sensor.resize(n, 2 * sensor.order());
    Matrix by_cameras(n, 2 * cameras.order());
    for (Eigen::Index i = 0; i < n; ++i) {
        const calibration::ResponseLine& line = lines[static_cast<std::size_t>(i)];
        const int q = out.q.emplace_back(static_cast<int>(std::lround(line.hz / sensor.frequency_hz)));
        out.rad(i) = line.lead_rad.value;
        out.by_sensor.row(i) = calibration::phase_gradient(sensor.at(q), q, out.by_sensor.cols());
        by_cameras.row(i) = calibration::phase_gradient(cameras.at(q), q, by_cameras.cols());
    }
    out.cameras = by_cameras * covariance_of(cameras) * by_cameras.transpose();
    if (!out.both()) return out;
    const calibration::Estimate &first = lines[0].log_gain, &second = lines[1].log_gain;
    out.log_rise = {second.value - first.value, std::hypot(bias_of_rise, first.sigma, second.sigma)};
    return out;
}

/// Corner in Hz and time between the instruments in rad of the first harmonic, which fit the leads.
struct Fit {
    Eigen::Vector2d at{0, 0};
    Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
    Matrix by_leads;        // derivative by the leads
    double by_told = 0;     // variance of the corner by the error of the stated one
    double time_alone = 0;  // variance of the time with a known corner
};

Fit fit(const Leads& leads, const Matrix& covariance, double f, const LowerCorner& stated) {
    Fit out;
    const double known =
        std::isfinite(stated.error_hz) ? 1 / std::pow(std::max(stated.error_hz, 1e-9), 2) : 0;
    const Matrix weights = covariance.inverse();
    out.at(0) = stated.hz;
    LowerCorner corner = stated;
    Matrix by(std::ssize(leads.q), 2);
    for (int pass = 0; pass < 8; ++pass) {
        Vector rest = leads.rad;
        corner.hz = out.at(0);
        for (Eigen::Index i = 0; i < by.rows(); ++i) {
            const double q = leads.q[static_cast<std::size_t>(i)];
            by.row(i) << corner.log_rate(q * f).imag(), q;
            rest(i) = std::remainder(rest(i) - std::arg(corner.at(q * f)) - q * out.at(1), two_pi);
        }
        Eigen::Matrix2d normal = by.transpose() * weights * by;
        out.time_alone = 1 / normal(1, 1);
        normal(0, 0) += known;
        out.covariance = normal.inverse();
        out.by_leads = out.covariance * by.transpose() * weights;
        out.at += out.by_leads * rest + out.covariance.col(0) * known * (stated.hz - out.at(0));
    }
    out.by_told = known * out.covariance(0, 0) * out.covariance(0, 0);
    return out;
}

/// phi by the cameras minus that by the accelerometer, corrected for the corner of its settings. bias: of
/// phi.
calibration::Estimate phi_off(const Leads& leads, const Matrix& covariance, double f,
                              const LowerCorner& stated, double bias) {
    Eigen::RowVectorXd turn = Eigen::RowVectorXd::Zero(covariance.rows());
    turn(0) = -2;
    turn(1) = 1;
    return {std::remainder(phi_turned(stated, f) - turn * leads.rad, two_pi),
            std::hypot(std::sqrt(turn * covariance * turn.transpose()),
                       phi_turned_by_hz(stated, f) * stated.error_hz, bias)};
}

/// A corner that fits the phases, with the probability of its kind. With equal phases, two poles lower the
/// amplitudes less than one, and those of a Butterworth filter less than equal ones.
struct Kind {
    LowerCorner corner{};
    Fit fit{};
    double share = 1;
};

void weigh(std::vector<Kind>& kinds, const calibration::Estimate& log_rise, double f) {
    std::vector<double> misfits;
    for (const Kind& k : kinds) {
        const double rise = std::log(std::abs(k.corner.at(2 * f) / k.corner.at(f)));
        misfits.push_back(std::pow((log_rise.value - rise) / log_rise.sigma, 2));
    }
    const double least = std::ranges::min(misfits);
    double sum = 0;
    for (std::size_t i = 0; i < kinds.size(); ++i) sum += kinds[i].share = std::exp((least - misfits[i]) / 2);
    for (Kind& k : kinds) k.share /= sum;
}

/// The stated corner weighed with the leads, by kind. poles: 0: one, two equal ones or Butterworth.
std::vector<Kind> weighed(const Leads& leads, const Matrix& covariance, double f, const LowerCorner& stated,
                          int poles) {
    if (leads.q.empty()) {
        Kind only{.corner = stated};
        only.fit.by_leads = Matrix::Zero(2, 0);
        only.fit.by_told = stated.error_hz * stated.error_hz;
        return {only};
    }
    std::vector<Kind> kinds{{.corner = stated}};
    const bool open = std::isinf(stated.error_hz) && leads.both();
    LowerCorner two = stated;
    two.poles = 2;
    if (open && poles == 0) kinds.push_back({.corner = two});
    two.damping = 1 / std::numbers::sqrt2;
    if (open && poles != 1) kinds.push_back({.corner = two});
    for (Kind& k : kinds) {
        k.fit = fit(leads, covariance, f, k.corner);
        k.corner.hz = k.fit.at(0);
    }
    if (kinds.size() > 1) weigh(kinds, leads.log_rise, f);
    return kinds;
}

/// Multiplies the harmonics by factors; returns the matrix that turns their real and imaginary parts.
Matrix multiply(HarmonicFit& fit, std::span<const std::complex<double>> factors) {
    Matrix turned = Matrix::Zero(2 * fit.order(), 2 * fit.order());
    for (Eigen::Index q = 0; q < fit.order(); ++q) {
        const std::complex<double> by = factors[static_cast<std::size_t>(q)];
        turned.block<2, 2>(2 * q, 2 * q) << by.real(), -by.imag(), by.imag(), by.real();
        fit.a[static_cast<std::size_t>(q)] *= by;
    }
    return turned;
}

void set_covariance(HarmonicFit& fit, const Matrix& covariance) {
    Eigen::Map<Eigen::Matrix<double, -1, -1, Eigen::RowMajor>>(fit.covariance.data(), covariance.rows(),
                                                               covariance.cols()) = covariance;
}

Vector numbers_of(std::span<const std::complex<double>> a) {
    Vector out(2 * std::ssize(a));
    for (Eigen::Index q = 0; q < std::ssize(a); ++q)
        out.segment<2>(2 * q) << a[static_cast<std::size_t>(q)].real(), a[static_cast<std::size_t>(q)].imag();
    return out;
}

/// The error of the low-pass enters the amplitudes here, phi by phi_error().
void divide(HarmonicFit& fit, const LowPass& pass) {
    if (pass.none()) return;
    std::vector<std::complex<double>> factors, lowered;
    for (int q = 1; q <= fit.order(); ++q) factors.push_back(1.0 / pass.at(q * fit.frequency_hz));
    const Matrix turned = multiply(fit, factors);
    for (int q = 1; q <= fit.order(); ++q)
        lowered.push_back(-fit.at(q) * pass.log_rate(q * fit.frequency_hz).real() * pass.error_hz);
    const Vector lower = numbers_of(lowered);
    set_covariance(fit, turned * covariance_of(fit) * turned.transpose() + lower * lower.transpose());
}

/// Divides the harmonics by the response of the corner. Their errors get those of the corner by the noise of
/// both instruments (variance: by the cameras') and of its kind. by_told: variance of the stated corner;
/// amplitudes alone get it here.
void divide(HarmonicFit& sensor, const std::vector<Kind>& kinds, const Eigen::RowVectorXd& corner_by_sensor,
            double variance, double by_told) {
    const auto n = static_cast<std::size_t>(sensor.order());
    const double f = sensor.frequency_hz;
    const LowerCorner& likeliest = std::ranges::max_element(kinds, {}, &Kind::share)->corner;
    std::vector<std::complex<double>> factors(n), rates(n), lowered(n);
    for (std::size_t i = 0; i < n; ++i)
        for (const Kind& k : kinds) factors[i] += k.share / k.corner.at(static_cast<double>(i + 1) * f);
    Matrix by_kind = Matrix::Zero(2 * sensor.order(), 2 * sensor.order());
    for (const Kind& k : kinds) {
        std::vector<std::complex<double>> other(n);
        for (std::size_t i = 0; i < n; ++i)
            other[i] = sensor.a[i] * (1.0 / k.corner.at(static_cast<double>(i + 1) * f) - factors[i]);
        by_kind += k.share * numbers_of(other) * numbers_of(other).transpose();
    }
    Matrix turned = multiply(sensor, factors);
    for (std::size_t i = 0; i < n; ++i) {
        const std::complex<double> rate = -likeliest.log_rate(static_cast<double>(i + 1) * f);
        rates[i] = sensor.a[i] * rate;
        lowered[i] = sensor.a[i] * rate.real();
    }
    const Vector by_hz = numbers_of(rates), lower = numbers_of(lowered);
    if (corner_by_sensor.size() > 0) turned += by_hz * corner_by_sensor;
    set_covariance(sensor, turned * covariance_of(sensor) * turned.transpose() + by_kind +
                               by_hz * variance * by_hz.transpose() + lower * by_told * lower.transpose());
}

}  // namespace

std::vector<calibration::ResponseLine> lines_of(const HarmonicFit& sensor, const HarmonicFit& cameras,
                                                double exposure_s) {
    std::vector<calibration::ResponseLine> lines;
    for (int q = 1; q <= std::min(sensor.order(), cameras.order()); ++q) {
        if (!sensor.stands_out(q) || !cameras.stands_out(q)) continue;
        const double f = q * sensor.frequency_hz, w = two_pi * f,
                     blur = boost::math::sinc_pi(w / 2 * exposure_s);
        const double turn = two_pi * q * sensor.frequency_hz * (sensor.origin_s - cameras.origin_s);
        const std::complex<double> a = sensor.at(q), x = cameras.at(q);
        lines.push_back({.hz = f,
                         .log_gain = {std::log(std::abs(a / x) * blur / (w * w)),
                                      std::hypot(sensor.amplitude_sd(q) / std::abs(a),
                                                 cameras.amplitude_sd(q) / std::abs(x))},
                         .lead_rad = {std::arg(a * std::conj(-x) * std::polar(1.0, -turn)),
                                      std::hypot(sensor.phase_sd(q), cameras.phase_sd(q))}});
    }
    return lines;
}

TakenOff take_off(const SensorResponse& stated, double exposure_s, const HarmonicFit& base,
                  HarmonicFit& sensor, std::array<HarmonicFit, 2>& across) {
    for (HarmonicFit* fit : {&sensor, &across[0], &across[1]}) divide(*fit, stated.upper);
    Corner out;
    LowerCorner by = stated.lower;
    by.poles = std::max(by.poles, 1);
    const double f = sensor.frequency_hz, w = two_pi * f;
    const double by_low_pass = stated.upper.phi_error(f);
    const double bias = std::isnan(by_low_pass) ? bias_without : std::hypot(bias_of_phi, by_low_pass);
    const Leads leads = leads_of(sensor, base, exposure_s);
    const Matrix covariance =
        leads.by_sensor * covariance_of(sensor) * leads.by_sensor.transpose() + leads.cameras;
    if (leads.both() && std::isfinite(by.error_hz)) {
        out.phi_off = phi_off(leads, covariance, f, by, bias);
        out.alarm = std::abs(out.phi_off.value) > agreeing * out.phi_off.sigma;
    }
    if (stated.lower.none()) {
        out.phi_told = by_low_pass;
        return {out};
    }
    out.unknown = !leads.both() && !std::isfinite(by.error_hz);
    if (out.unknown) return {out};
    by.error_hz = std::hypot(by.error_hz, bias / phi_turned_by_hz(by, f));
    if (out.alarm) {
        by.hz = 0;
        by.error_hz = std::numeric_limits<double>::infinity();
    }
    const std::vector<Kind> kinds = weighed(leads, covariance, f, by, stated.lower.poles);
    const Fit& first = kinds.front().fit;
    const Kind& likeliest = *std::ranges::max_element(kinds, {}, &Kind::share);
    out.hz = leads.q.empty() ? calibration::Estimate{by.hz, by.error_hz}
                             : calibration::Estimate{first.at(0), std::sqrt(first.covariance(0, 0))};
    const Eigen::RowVectorXd row = likeliest.fit.by_leads.row(0), by_sensor = row * leads.by_sensor;
    const double by_cameras = row * leads.cameras * row.transpose(), by_told = likeliest.fit.by_told;
    const double by_noise = by_sensor * covariance_of(sensor) * by_sensor.transpose();
    const LowerCorner& corner = likeliest.corner;
    if (std::isfinite(by.error_hz)) out.phi_told = std::abs(phi_turned_by_hz(corner, f)) * std::sqrt(by_told);
    out.large = std::abs(corner.at(f)) < 1 - most_lowered;

    divide(sensor, kinds, by_sensor, by_cameras, by_told);
    for (HarmonicFit& fit : across) divide(fit, kinds, {}, by_cameras + by_noise, by_told);
    return {out, likeliest.fit.at(1) / w,
            (likeliest.fit.covariance(1, 1) - likeliest.fit.time_alone) / (w * w)};
}

}  // namespace shaker::reduction
