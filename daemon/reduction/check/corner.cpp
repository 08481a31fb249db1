#include "daemon/reduction/check/corner.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <boost/math/special_functions/sinc.hpp>
#include <cmath>
#include <limits>
#include <vector>

#include "drivers/drive.hpp"

namespace shaker::reduction {

namespace {

constexpr double agreeing = 4;         // standard errors
constexpr double most_lowered = 0.1;   // of an amplitude
constexpr double bias_of_phi = 3e-4;   // rad: trackers, a low-pass of 500 Hz
constexpr double bias_of_rise = 2e-4;  // of the ratio of two amplitudes: trackers, exposure

using calibration::HarmonicFit;
using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

Matrix covariance_of(const HarmonicFit& fit) {
    const Eigen::Index n = 2 * fit.order();
    return Eigen::Map<const Eigen::Matrix<double, -1, -1, Eigen::RowMajor>>(fit.covariance.data(), n, n);
}

/// Derivative of the phase of a_q by Re a_1, Im a_1, Re a_2, ...
Eigen::RowVectorXd phase_by(const HarmonicFit& fit, int q) {
    Eigen::RowVectorXd row = Eigen::RowVectorXd::Zero(2 * fit.order());
    row.segment<2>(2 * (q - 1)) << -fit.at(q).imag(), fit.at(q).real();
    return row / std::norm(fit.at(q));
}

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
    constexpr int most = 3;
    Leads out;
    for (int q = 1; q <= std::min({sensor.order(), cameras.order(), most}); ++q)
        if (sensor.stands_out(q) && cameras.stands_out(q)) out.q.push_back(q);
    const auto n = std::ssize(out.q);
    out.rad.resize(n);
    out.by_sensor.resize(n, 2 * sensor.order());
    Matrix by_cameras(n, 2 * cameras.order());
    for (Eigen::Index i = 0; i < n; ++i) {
        const int q = out.q[static_cast<std::size_t>(i)];
        const double turn = two_pi * q * sensor.frequency_hz * (sensor.origin_s - cameras.origin_s);
        out.rad(i) = std::arg(sensor.at(q) * std::conj(-cameras.at(q)) * std::polar(1.0, -turn));
        out.by_sensor.row(i) = phase_by(sensor, q);
        by_cameras.row(i) = phase_by(cameras, q);
    }
    out.cameras = by_cameras * covariance_of(cameras) * by_cameras.transpose();
    if (!out.both()) return out;
    for (const int q : {1, 2}) {
        const double blur = boost::math::sinc_pi(two_pi / 2 * q * sensor.frequency_hz * exposure_s),
                     ratio = std::abs(sensor.at(q) / cameras.at(q)) * blur / (q * q);
        out.log_rise.value = q == 1 ? -std::log(ratio) : out.log_rise.value + std::log(ratio);
        out.log_rise.sigma = std::hypot(q == 1 ? bias_of_rise : out.log_rise.sigma,
                                        sensor.amplitude_sd(q) / std::abs(sensor.at(q)),
                                        cameras.amplitude_sd(q) / std::abs(cameras.at(q)));
    }
    return out;
}

/// Corner in Hz and time between the instruments in rad of the first harmonic, which fit the leads.
struct Fit {
    Eigen::Vector2d at{0, 0};
    Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
    Matrix by_leads;        // derivative by the leads
    double by_told = 0;     // variance of the corner by the error of the told one
    double time_alone = 0;  // variance of the time with a known corner
};

Fit fit(const Leads& leads, const Matrix& covariance, double f, const LowerCorner& told) {
    Fit out;
    const double known = std::isfinite(told.error_hz) ? 1 / std::pow(std::max(told.error_hz, 1e-9), 2) : 0;
    const Matrix weights = covariance.inverse();
    out.at(0) = told.hz;
    Matrix by(std::ssize(leads.q), 2);
    for (int pass = 0; pass < 8; ++pass) {
        Vector rest = leads.rad;
        for (Eigen::Index i = 0; i < by.rows(); ++i) {
            const double q = leads.q[static_cast<std::size_t>(i)], x = out.at(0) / (q * f);
            by.row(i) << told.poles / (q * f) / (1 + x * x), q;
            rest(i) = std::remainder(rest(i) - told.poles * std::atan(x) - q * out.at(1), two_pi);
        }
        Eigen::Matrix2d normal = by.transpose() * weights * by;
        out.time_alone = 1 / normal(1, 1);
        normal(0, 0) += known;
        out.covariance = normal.inverse();
        out.by_leads = out.covariance * by.transpose() * weights;
        out.at += out.by_leads * rest + out.covariance.col(0) * known * (told.hz - out.at(0));
    }
    out.by_told = known * out.covariance(0, 0) * out.covariance(0, 0);
    return out;
}

/// Derivative by the corner, rad/Hz, of phi as such a sensor has it.
double phi_by(const LowerCorner& corner, double f) {
    const double x = corner.hz / f;
    return corner.poles * (0.5 / (1 + x * x / 4) - 2 / (1 + x * x)) / f;
}

/// phi by the cameras minus that by the accelerometer, corrected for the corner of its settings.
calibration::Estimate phi_off(const Leads& leads, const Matrix& covariance, double f,
                              const LowerCorner& told) {
    const double x = told.hz / f;
    Eigen::RowVectorXd turn = Eigen::RowVectorXd::Zero(covariance.rows());
    turn(0) = -2;
    turn(1) = 1;
    const double told_turn = told.poles * (std::atan(x / 2) - 2 * std::atan(x));
    return {std::remainder(told_turn - turn * leads.rad, two_pi),
            std::hypot(std::sqrt(turn * covariance * turn.transpose()), phi_by(told, f) * told.error_hz,
                       bias_of_phi)};
}

/// A corner whose number of poles may be another one: with equal phases, two poles lower the amplitudes less.
struct Response {
    LowerCorner corner, other;
    double share = 0;  // probability of the other one
};

Response likelier(const Response& one, const Response& two, const calibration::Estimate& log_rise, double f) {
    const auto misfit = [&](const LowerCorner& c) {
        const double rise = std::log(std::abs(c.at(2 * f) / c.at(f)));
        return std::pow((log_rise.value - rise) / log_rise.sigma, 2);
    };
    const double of_two = 1 / (1 + std::exp((misfit(two.corner) - misfit(one.corner)) / 2));
    return of_two > 0.5 ? Response{two.corner, one.corner, 1 - of_two}
                        : Response{one.corner, two.corner, of_two};
}

struct Found {
    Response response;
    Fit fit;
    calibration::Estimate hz;  // as Corner
};

/// The told corner weighed with the leads. either: it has one pole or two.
Found weighed(const Leads& leads, const Matrix& covariance, double f, const LowerCorner& told, bool either) {
    Found out{.response = {told, told}, .fit = {}, .hz = {told.hz, told.error_hz}};
    const auto n = std::ssize(leads.q);
    out.fit.by_leads = Matrix::Zero(2, n);
    out.fit.by_told = told.error_hz * told.error_hz;
    if (n == 0) return out;
    const auto with = [&](int poles) {
        Found found{.response = {told, told}, .fit = {}, .hz = {}};
        found.response.corner.poles = poles;
        found.fit = fit(leads, covariance, f, found.response.corner);
        found.hz = {found.fit.at(0), std::sqrt(found.fit.covariance(0, 0))};
        found.response.corner.hz = found.hz.value;
        found.response.other = found.response.corner;
        return found;
    };
    out = with(told.poles);
    if (!either) return out;
    Found two = with(2);
    two.hz = out.hz;
    const Response response = likelier(out.response, two.response, leads.log_rise, f);
    if (response.corner.poles == 2) out = two;
    out.response = response;
    return out;
}

/// Divides the harmonics by the response. Their errors get those of the corner by the noise of both
/// instruments (variance: by the cameras') and of the number of poles. by_told: variance of the told corner;
/// amplitudes alone get it here.
void divide(HarmonicFit& sensor, const Response& response, const Eigen::RowVectorXd& corner_by_sensor,
            double variance, double by_told) {
    const LowerCorner& corner = response.corner;
    const Eigen::Index n = 2 * sensor.order();
    Matrix turned = Matrix::Zero(n, n);
    Vector by_hz(n), by_poles(n), lowered(n);
    for (int q = 1; q <= sensor.order(); ++q) {
        const double qf = q * sensor.frequency_hz;
        const std::complex<double> factor = 1.0 / corner.at(qf), a = sensor.at(q) * factor,
                                   rate = static_cast<double>(-corner.poles) *
                                          std::complex<double>{0, 1 / qf} /
                                          std::complex<double>{1, -corner.hz / qf},
                                   by = a * rate, lower = a * rate.real(),
                                   other = sensor.at(q) / response.other.at(qf) - a;
        const Eigen::Index i = 2 * (q - 1);
        turned.block<2, 2>(i, i) << factor.real(), -factor.imag(), factor.imag(), factor.real();
        by_hz.segment<2>(i) << by.real(), by.imag();
        lowered.segment<2>(i) << lower.real(), lower.imag();
        by_poles.segment<2>(i) << other.real(), other.imag();
        sensor.a[static_cast<std::size_t>(q - 1)] = a + response.share * other;
    }
    if (corner_by_sensor.size() > 0) turned += by_hz * corner_by_sensor;
    Eigen::Map<Eigen::Matrix<double, -1, -1, Eigen::RowMajor>> stored(sensor.covariance.data(), n, n);
    const Matrix wider = turned * stored * turned.transpose() + by_hz * variance * by_hz.transpose() +
                         lowered * by_told * lowered.transpose() +
                         response.share * (1 - response.share) * by_poles * by_poles.transpose();
    stored = wider;
}

}  // namespace

TakenOff take_off(const LowerCorner& told, double exposure_s, const HarmonicFit& base, HarmonicFit& sensor,
                  std::array<HarmonicFit, 2>& across) {
    Corner out;
    LowerCorner by = told;
    by.poles = std::max(told.poles, 1);
    const double f = sensor.frequency_hz, w = two_pi * f;
    const Leads leads = leads_of(sensor, base, exposure_s);
    const Matrix covariance =
        leads.by_sensor * covariance_of(sensor) * leads.by_sensor.transpose() + leads.cameras;
    if (leads.both() && std::isfinite(told.error_hz)) {
        out.phi_off = phi_off(leads, covariance, f, by);
        out.alarm = std::abs(out.phi_off.value) > agreeing * out.phi_off.sigma;
    }
    if (told.none()) return {out};
    out.unknown = !leads.both() && !std::isfinite(told.error_hz);
    if (out.unknown) return {out};
    by.error_hz = std::hypot(by.error_hz, bias_of_phi / phi_by(by, f));
    if (out.alarm) by = {.error_hz = std::numeric_limits<double>::infinity(), .poles = by.poles};
    const Found found = weighed(leads, covariance, f, by, told.poles == 0 && leads.both());
    out.hz = found.hz;
    by = found.response.corner;
    const Eigen::RowVectorXd row = found.fit.by_leads.row(0), by_sensor = row * leads.by_sensor;
    const double by_cameras = row * leads.cameras * row.transpose(), by_told = found.fit.by_told;
    const double by_noise = by_sensor * covariance_of(sensor) * by_sensor.transpose();
    if (std::isfinite(by.error_hz)) out.phi_told = std::abs(phi_by(by, f)) * std::sqrt(by_told);
    out.large = std::abs(by.at(f)) < 1 - most_lowered;

    divide(sensor, found.response, by_sensor, by_cameras, by_told);
    for (HarmonicFit& fit : across) divide(fit, found.response, {}, by_cameras + by_noise, by_told);
    return {out, found.fit.at(1) / w, (found.fit.covariance(1, 1) - found.fit.time_alone) / (w * w)};
}

}  // namespace shaker::reduction
