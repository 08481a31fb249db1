#pragma once
// Least-squares fit of a periodic signal to samples at any times: gaps, several streams, optional drift.
#include <complex>
#include <span>
#include <vector>

#include "calibration/estimate.hpp"

namespace shaker::calibration {

/// Samples of one stream. Streams share harmonics and slope; each has its own constant.
struct HarmonicSamples {
    std::span<const double> t;   // s
    std::span<const double> y;   // any unit
    std::span<const double> sd;  // of y, > 0; empty: all 1
};

/// y(t) = c_stream + slope (t - origin_s) + Im sum_q a[q-1] e^{i q w (t - origin_s)}, w = 2 pi frequency.
/// Minimises chi^2 = sum ((y - model) / sd)^2.
struct HarmonicFit {
    double frequency_hz = 0;
    double origin_s = 0;  // weighted mean of all t: there phases and frequency are uncorrelated
    std::vector<std::complex<double>> a;
    std::vector<double> constants;  // one per stream
    Estimate slope;                 // unit/s; 0 when not fitted
    std::vector<double>
        covariance;    // of Re a1, Im a1, Re a2, ..., row by row; assumes white noise of the residuals' size
    double scale = 0;  // sqrt(chi^2 / degrees of freedom): residuals in units of sd
    double rms = 0;    // of the unweighted residuals, in the unit of y
    std::size_t samples = 0;
    std::vector<double> stream_rms;  // rms of each stream's residuals in units of its sd

    [[nodiscard]] int order() const noexcept { return static_cast<int>(a.size()); }
    [[nodiscard]] std::complex<double> at(int q) const { return a.at(static_cast<std::size_t>(q - 1)); }
    /// The periodic part alone.
    [[nodiscard]] double periodic(double t_s) const noexcept;
    /// The same at many times, much faster. `out` must be as long as `t_s`.
    void periodic(std::span<const double> t_s, std::span<double> out) const noexcept;
    /// Covariance of components i and j; i = 2(q-1) for Re a_q, 2(q-1)+1 for Im a_q.
    [[nodiscard]] double cov(int i, int j) const;
    /// Standard deviation of |a_q|, and of its phase in rad (at most pi/sqrt 3, that of an unknown phase).
    [[nodiscard]] double amplitude_sd(int q) const;
    [[nodiscard]] double phase_sd(int q) const;
    /// |a_q| exceeds four standard deviations.
    [[nodiscard]] bool stands_out(int q) const { return std::abs(at(q)) > 4 * amplitude_sd(q); }
};

enum class Slope { none, free };

/// Fits harmonics 1..order at a known frequency. Throws InputError with the counts when there are not more
/// samples than unknowns, or when the harmonics are not separable at these times.
HarmonicFit fit_harmonics(std::span<const HarmonicSamples> streams, double frequency_hz, int order,
                          Slope slope);

/// The same fit, without slope and weights, for several signals sampled at the same times.
std::vector<HarmonicFit> fit_signals(std::span<const double> t,
                                     std::span<const std::span<const double>> signals, double frequency_hz,
                                     int order);

/// The frequency of the best fit with its standard deviation. Gauss-Newton from `near_hz` on windows that
/// grow from 8 periods, so `near_hz` may be wrong by 1 % for records of any length. Sigma is NaN when it did
/// not converge.
Estimate refine_frequency(std::span<const HarmonicSamples> streams, double near_hz, int order);
/// The same from a frequency known with a standard deviation; windows that it makes unnecessary are skipped.
Estimate refine_frequency(std::span<const HarmonicSamples> streams, const Estimate& near, int order);

/// Highest harmonic for `samples_per_period`: a third of it, at least 1 and at most `most`.
int order_for(double samples_per_period, int most);

/// Median interval of increasing times; 0 for fewer than two.
double median_step(std::span<const double> t);

}  // namespace shaker::calibration
