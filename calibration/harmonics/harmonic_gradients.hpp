#pragma once
// Covariance of a harmonic fit and derivatives by its amplitudes, as matrices: by Re a1, Im a1, Re a2, ...
#include <Eigen/Dense>
#include <algorithm>

#include "calibration/harmonics/harmonic_fit.hpp"

namespace shaker::calibration {

/// A view of the numbers of `fit`.
inline auto covariance_of(const HarmonicFit& fit) {
    return Eigen::Map<const Eigen::Matrix<double, -1, -1, Eigen::RowMajor>>(fit.covariance.data(),
                                                                            2 * fit.order(), 2 * fit.order());
}

/// Derivative of the amplitude of harmonic q = 1, 2, ..., which is `a`; `size`: numbers of the fit.
inline Eigen::VectorXd amplitude_gradient(std::complex<double> a, Eigen::Index q, Eigen::Index size) {
    Eigen::VectorXd g = Eigen::VectorXd::Zero(size);
    g.segment<2>(2 * (q - 1)) << a.real(), a.imag();
    return g / std::max(std::abs(a), 1e-300);
}

/// The same of its phase.
inline Eigen::VectorXd phase_gradient(std::complex<double> a, Eigen::Index q, Eigen::Index size) {
    Eigen::VectorXd g = Eigen::VectorXd::Zero(size);
    g.segment<2>(2 * (q - 1)) << -a.imag(), a.real();
    return g / std::max(std::norm(a), 1e-300);
}

}  // namespace shaker::calibration
