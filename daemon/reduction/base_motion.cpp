#include "daemon/reduction/base_motion.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <complex>
#include <numeric>

#include "calibration/harmonics/harmonic_gradients.hpp"
#include "calibration/harmonics/phasors.hpp"
#include "drivers/drive.hpp"

namespace shaker::reduction {
namespace {

using calibration::amplitude_gradient;
using calibration::phase_gradient;
using Gradient = Eigen::VectorXd;

calibration::Estimate estimate(double value, const Gradient& g, const Eigen::MatrixXd& covariance) {
    return {value, std::sqrt(std::max(0.0, g.dot(covariance * g)))};
}

/// The standard deviation of a phase is at most pi/sqrt 3, that of an unknown phase within +-pi.
calibration::Estimate phase(double value, const Gradient& g, const Eigen::MatrixXd& covariance) {
    calibration::Estimate e = estimate(std::remainder(value, two_pi), g, covariance);
    e.sigma = std::min(e.sigma, two_pi / std::sqrt(12.0));
    return e;
}

struct GammaPhi {
    calibration::Estimate gamma, rho, phi;
};

GammaPhi gamma_phi(std::complex<double> a1, std::complex<double> a2, const Eigen::MatrixXd& covariance) {
    const Eigen::Index n = covariance.rows();
    const double A1 = std::abs(a1), A2 = std::abs(a2), sum = std::max(A1 + A2, 1e-300);
    const Gradient g1 = amplitude_gradient(a1, 1, n), g2 = amplitude_gradient(a2, 2, n);
    const Gradient turn = phase_gradient(a2, 2, n) - 2 * phase_gradient(a1, 1, n);
    return {estimate(A1 + A2, g1 + g2, covariance),
            estimate(A1 / sum, (A2 * g1 - A1 * g2) / (sum * sum), covariance),
            phase(std::arg(a2) - 2 * std::arg(a1), turn, covariance)};
}

}  // namespace

BaseMotion drive_measured(const calibration::HarmonicFit& fit) {
    const Eigen::Index n = 2 * fit.order();
    const Eigen::MatrixXd covariance = calibration::covariance_of(fit);
    BaseMotion out;
    const double w = two_pi * fit.frequency_hz;
    double v2 = 0;
    Gradient v2_gradient = Gradient::Zero(n);
    const Gradient alpha1 = phase_gradient(fit.at(1), 1, n);
    for (int q = 1; q <= fit.order(); ++q) {
        const double A = std::abs(fit.at(q)), qw = q * w;
        const Gradient by_amplitude = amplitude_gradient(fit.at(q), q, n);
        v2 += A * A / (2 * qw * qw);
        v2_gradient += A / (qw * qw) * by_amplitude;
        const Gradient turn = phase_gradient(fit.at(q), q, n) - q * alpha1;
        out.harmonics.push_back({q, estimate(A, by_amplitude, covariance),
                                 phase(std::arg(fit.at(q)) - q * std::arg(fit.at(1)), turn, covariance)});
    }
    out.harmonics.front().phase = {0, 0};  // phase 0 of harmonic 1 defines the time origin
    const double v_rms = std::sqrt(v2);
    out.v_rms = estimate(v_rms, v2_gradient / std::max(2 * v_rms, 1e-300), covariance);
    if (fit.order() >= 2) {
        const GammaPhi g = gamma_phi(fit.at(1), fit.at(2), covariance);
        out.gamma = g.gamma;
        out.rho = g.rho;
        out.phi = g.phi;
    } else {
        out.gamma = out.harmonics.front().amplitude;
        out.rho = {1, 0};
    }
    return out;
}

int times_too_low(const calibration::HarmonicFit& fit) {
    constexpr double moves = 0.1;  // of the largest harmonic; distortion of a single one is less
    double largest = 0;
    for (int q = 1; q <= fit.order(); ++q) largest = std::max(largest, std::abs(fit.at(q)));
    int divisor = 0, count = 0;
    for (int q = 1; q <= fit.order(); ++q) {
        if (!fit.stands_out(q) || std::abs(fit.at(q)) < moves * largest) continue;
        divisor = std::gcd(divisor, q);
        ++count;
    }
    return count > 1 ? divisor : 1;
}

std::vector<PeriodResult> drive_by_period(const calibration::HarmonicFit& fit, std::span<const double> t_s,
                                          std::span<const double> a_mps2, double t0_s) {
    using Row = Eigen::Matrix<double, 5, 1>;
    std::vector<PeriodResult> out;
    if (fit.order() < 2) return out;
    const double f = fit.frequency_hz, usual = 1 / (calibration::median_step(t_s) * f);
    Eigen::Matrix<double, 5, 5> normal = Eigen::Matrix<double, 5, 5>::Zero();
    Row right = Row::Zero();
    int count = 0;
    const auto finish = [&](int k) {
        const Eigen::LDLT<Eigen::Matrix<double, 5, 5>> ldlt(normal);
        if (k >= 0 && count >= 0.9 * usual && count > 5 && ldlt.rcond() > 1e-6) {
            const Row c = ldlt.solve(right);
            const Eigen::Matrix<double, 5, 5> inverse = ldlt.solve(Eigen::Matrix<double, 5, 5>::Identity());
            const Eigen::MatrixXd covariance = fit.scale * fit.scale * inverse.topLeftCorner<4, 4>();
            const GammaPhi g = gamma_phi(fit.at(1) + std::complex<double>(c(0), c(1)),
                                         fit.at(2) + std::complex<double>(c(2), c(3)), covariance);
            PeriodResult& p = out.emplace_back();
            p.k = k;
            p.t_s = t0_s + k / f;
            p.gamma = g.gamma;
            p.phi = g.phi;
        }
        normal.setZero();
        right.setZero();
        count = 0;
    };
    int now = -1;
    constexpr std::size_t block = calibration::Phasors::size;
    std::array<double, block> turns{}, periodic{};
    for (std::size_t begin = 0; begin < t_s.size(); begin += block) {
        const std::size_t samples = std::min(block, t_s.size() - begin);
        for (std::size_t i = 0; i < samples; ++i) turns[i] = f * (t_s[begin + i] - fit.origin_s);
        const calibration::Phasors z = calibration::phasors(turns);
        fit.periodic(t_s.subspan(begin, samples), periodic);
        for (std::size_t i = 0; i < samples; ++i) {
            const double periods = (t_s[begin + i] - t0_s) * f;
            if (periods < 0) continue;
            if (static_cast<int>(periods) != now) finish(now);
            now = static_cast<int>(periods);
            const double c = z.re[i], s = z.im[i];
            const Row row{s, c, 2 * s * c, c * c - s * s, 1.0};
            normal += row * row.transpose();
            right += (a_mps2[begin + i] - fit.constants[0] - periodic[i]) * row;
            ++count;
        }
    }
    finish(now);
    return out;
}

void measure_across(const Alignment& drive, int axes, std::vector<MeasuredHarmonic>& harmonics) {
    for (MeasuredHarmonic& h : harmonics) {
        double variance = axes == 3 ? 0 : NAN;
        for (const calibration::HarmonicFit& fit : drive.across)
            for (const int i : {2 * (h.q - 1), 2 * (h.q - 1) + 1}) variance += fit.cov(i, i) / 4;
        h.across = calibration::transverse(drive.acceleration.at(h.q),
                                           {drive.across[0].at(h.q), drive.across[1].at(h.q)},
                                           drive.shaker_axis, std::sqrt(variance));
    }
}

}  // namespace shaker::reduction
