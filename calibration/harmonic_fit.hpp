#pragma once
// Least squares of a periodic signal on samples at any times: gaps, several streams, an optional drift.
#include <complex>
#include <span>
#include <vector>

#include "calibration/estimate.hpp"

namespace shaker {

/// Samples of one stream; streams share the harmonics and the slope, each has its own constant.
struct HarmonicSamples {
    std::span<const double> t;   // s
    std::span<const double> y;   // any unit
    std::span<const double> sd;  // of y, > 0; empty: all 1
};

/// y(t) = c_stream + slope (t - origin_s) + Im sum_q a[q-1] e^{i q w (t - origin_s)}.
struct HarmonicFit {
    double frequency_hz = 0;
    double origin_s = 0;  // weighted mean of all t: there phases and frequency are uncorrelated
    std::vector<std::complex<double>> a;
    std::vector<double> constants;  // one a stream
    Estimate slope;                 // unit/s; 0 when not asked for
    std::vector<double>
        covariance;    // of Re a1, Im a1, Re a2, ..., row by row; white noise of the residuals' size
    double scale = 0;  // sqrt(chi^2 / degrees of freedom): residuals in units of sd
    double rms = 0;    // residuals, plain, in the unit of y
    std::size_t samples = 0;
    std::vector<double> stream_rms;  // residuals of each stream in units of its sd

    [[nodiscard]] int order() const noexcept { return static_cast<int>(a.size()); }
    [[nodiscard]] std::complex<double> at(int q) const { return a.at(static_cast<std::size_t>(q - 1)); }
    /// Periodic part alone.
    [[nodiscard]] double periodic(double t_s) const noexcept;
    /// The same at many times, much faster; `out` is as long as `t_s`.
    void periodic(std::span<const double> t_s, std::span<double> out) const noexcept;
    /// Covariance of component i with j, i = 2(q-1) for Re a_q, 2(q-1)+1 for Im a_q.
    [[nodiscard]] double cov(int i, int j) const;
    /// Standard deviation of |a_q|, and of its phase in rad (at most that of an unknown phase, pi/sqrt 3).
    [[nodiscard]] double amplitude_sd(int q) const;
    [[nodiscard]] double phase_sd(int q) const;
};

enum class Slope { none, free };

/// Fits harmonics 1..order at a known frequency. Throws InputError naming the counts when there are not more
/// samples than unknowns or when the times cannot tell the harmonics apart.
HarmonicFit fit_harmonics(std::span<const HarmonicSamples> streams, double frequency_hz, int order,
                          Slope slope);

/// The same fit, without slope and weights, to each of several signals that have their samples at the same
/// times.
std::vector<HarmonicFit> fit_signals(std::span<const double> t,
                                     std::span<const std::span<const double>> signals, double frequency_hz,
                                     int order);

/// The frequency that fits best, with its standard deviation, by Gauss-Newton from `near_hz` on windows
/// growing from 8 periods: `near_hz` may be wrong by 1 %, however long the record. NaN sigma when it did not
/// converge.
Estimate refine_frequency(std::span<const HarmonicSamples> streams, double near_hz, int order);
/// The same from what is known already with a standard deviation: only the windows that it cannot do without
/// are gone through.
Estimate refine_frequency(std::span<const HarmonicSamples> streams, const Estimate& near, int order);

/// Harmonics that `samples_per_period` can carry: a third of them, at most `most`; at least 1.
int order_for(double samples_per_period, int most);

/// Median distance of increasing times; 0 for less than two.
double median_step(std::span<const double> t);

}  // namespace shaker
