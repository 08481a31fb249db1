#pragma once
// A least-squares fit of harmonics: its model, the sums over samples, block by block, and their solution.
#include <Eigen/Dense>
#include <complex>
#include <span>
#include <vector>

#include "calibration/harmonic_fit.hpp"

namespace shaker {

/// Columns: sin and cos of each harmonic, the slope where wanted, the constant, and the signal's derivative
/// by frequency where amplitudes are given for it.
struct HarmonicModel {
    double frequency_hz = 0;
    double origin_s = 0;
    double half_span_s =
        1;  // the slope's column runs over about -1..1: the normal equations stay well scaled
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

/// With its origin at the weighted mean of the times of all streams.
HarmonicModel model_of(std::span<const HarmonicSamples> streams, double frequency_hz, int order, Slope slope);

/// Sums over the samples of one stream, divided by their sd: columns with columns, columns with signals.
struct NormalEquations {
    Eigen::MatrixXd normal;  // lower half
    Eigen::MatrixXd right;   // one column a signal
};
NormalEquations normal_equations(const HarmonicModel& model, std::span<const double> t,
                                 std::span<const double> sd,
                                 std::span<const std::span<const double>> signals);

/// What parameters (one column a signal) leave of signals.
struct Remainder {
    double chi2 = 0;     // in units of sd
    double squares = 0;  // plain
};
std::vector<Remainder> remainders(const HarmonicModel& model, std::span<const double> t,
                                  std::span<const double> sd,
                                  std::span<const std::span<const double>> signals,
                                  const Eigen::MatrixXd& parameters);

/// Solved normal equations.
struct Solution {
    Eigen::MatrixXd p;        // one column a signal
    Eigen::MatrixXd inverse;  // of the normal matrix
};
/// `normal`: lower half. Throws InputError when there are not more samples than unknowns or when the times
/// cannot tell the harmonics apart.
Solution solve(const HarmonicModel& model, const NormalEquations& sums, std::size_t samples);
/// The harmonics among the parameters of one signal.
std::vector<std::complex<double>> amplitudes(const Eigen::VectorXd& p, int order);
/// What a fit says of one signal, but for the number of samples, which it has already, and what each stream
/// left.
void set_solution(HarmonicFit& fit, const HarmonicModel& model, const Solution& solved, Eigen::Index signal,
                  const Remainder& left);

}  // namespace shaker
