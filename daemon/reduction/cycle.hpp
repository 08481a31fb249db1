#pragma once
// Everything seen as one period: the base by its harmonics, the walker folded.
#include <array>
#include <complex>
#include <span>
#include <vector>

#include "calibration/harmonic_fit.hpp"
#include "daemon/reduction/drift.hpp"
#include "daemon/reduction/reduction.hpp"

namespace shaker {

/// The base's motion against phase p = (t - t0) f, any p. Position and velocity have zero mean.
class BaseCycle {
public:
    /// From its acceleration; phase 0 is where harmonic 1 crosses zero upwards.
    explicit BaseCycle(const HarmonicFit& acceleration);
    [[nodiscard]] double a(double p) const noexcept { return sum(a_, p); }  // m/s^2
    [[nodiscard]] double v(double p) const noexcept { return sum(v_, p); }  // m/s
    [[nodiscard]] double x(double p) const noexcept { return sum(x_, p); }  // m
    /// First start of a period not before t.
    [[nodiscard]] double start_after(double t_s) const noexcept;
    [[nodiscard]] double period_s() const noexcept { return period_s_; }

private:
    using Terms = std::vector<std::complex<double>>;
    static double sum(const Terms& terms, double p) noexcept;
    Terms a_, v_, x_;
    double period_s_, start_s_;
};

/// A walker position on the phase axis, drift and slow wandering from period to period taken off.
struct Folded {
    double phase;  // 0..1
    double x_m;    // periodic
    double sd_m;
};

/// All positions of all views, in order of phase.
std::vector<Folded> fold(std::span<const MotionSeries> walkers, const Drift& drift, double t0_s,
                         double frequency_hz);

/// Walker and base over one period at 50..200 phases (the frames' own when a period is a whole number of
/// frames). Position and velocity come from a quartic over the 7 nearest frames' width at the samples' true
/// phases: on a commensurate grid the 7-point quartic Savitzky-Golay filter. sd: from the scatter about it,
/// kinks included; the bias beside a kink (a jump da of acceleration) is up to about 0.25 da / frame rate in
/// v.
Cycle make_cycle(std::span<const Folded> folded, const BaseCycle& base, double v_D, double frames_per_period);

}  // namespace shaker
