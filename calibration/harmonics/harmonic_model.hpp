#pragma once
// Model of a least-squares fit of harmonics, sums over blocks of samples, and solution of the normal
// equations.
#include <Eigen/Dense>
#include <complex>
#include <span>
#include <vector>

#include "calibration/harmonics/harmonic_fit.hpp"

namespace shaker::calibration {

/// Columns in order: sin and cos of each harmonic, the slope (optional), the constant, and the signal's
/// derivative with respect to frequency (if amplitudes for it are given).
struct HarmonicModel {
    double frequency_hz = 0;
    double origin_s = 0;
    double half_span_s = 1;  // scales the slope's column to about -1..1 for well-conditioned normal equations
    int order = 1;
    Slope slope = Slope::none;
    std::span<const std::complex<double>> derivative_of{};

    [[nodiscard]] int constant_column() const { return 2 * order + (slope == Slope::free ? 1 : 0); }
    [[nodiscard]] int columns() const { return constant_column() + 1 + (derivative_of.empty() ? 0 : 1); }
};

/// Sums over the samples of a stream.
struct TimeWeight {
    double weight = 0;      // 1/sd^2
    double weighted_t = 0;  // t/sd^2, s
};
TimeWeight time_weight(const HarmonicSamples& stream);

/// Model whose origin is the weighted mean of the times of all streams.
HarmonicModel model_of(std::span<const HarmonicSamples> streams, double frequency_hz, int order, Slope slope);

/// Sums over the samples of one stream, weighted by 1/sd^2: columns times columns, columns times signals.
struct NormalEquations {
    Eigen::MatrixXd normal;  // lower half
    Eigen::MatrixXd right;   // one column per signal
};
NormalEquations normal_equations(const HarmonicModel& model, std::span<const double> t,
                                 std::span<const double> sd,
                                 std::span<const std::span<const double>> signals);

/// Residuals of signals for given parameters (one column per signal).
struct Remainder {
    double chi2 = 0;     // sum of squares in units of sd
    double squares = 0;  // sum of squares, unweighted
};
std::vector<Remainder> remainders(const HarmonicModel& model, std::span<const double> t,
                                  std::span<const double> sd,
                                  std::span<const std::span<const double>> signals,
                                  const Eigen::MatrixXd& parameters);

/// Solved normal equations.
struct Solution {
    Eigen::MatrixXd p;        // one column per signal
    Eigen::MatrixXd inverse;  // of the normal matrix
};
/// `normal`: lower half. Throws InputError when there are not more samples than unknowns, or when the
/// harmonics are not separable at these times.
Solution solve(const HarmonicModel& model, const NormalEquations& sums, std::size_t samples);
/// Complex amplitudes from the parameters of one signal.
std::vector<std::complex<double>> amplitudes(const Eigen::VectorXd& p, int order);
/// Sets the results for one signal. Already set: `samples`. Left to the caller: `stream_rms`.
void set_solution(HarmonicFit& fit, const HarmonicModel& model, const Solution& solved, Eigen::Index signal,
                  const Remainder& left);

}  // namespace shaker::calibration
