#pragma once
// One period of the motion: the base from its harmonics, the walker's positions folded.
#include <complex>
#include <span>
#include <vector>

#include "calibration/harmonics/harmonic_fit.hpp"
#include "daemon/reduction/drift.hpp"
#include "daemon/reduction/reduction.hpp"

namespace shaker::reduction {

/// Motion of the base at phase p = (t - t0) f, for any p. From a(p) = Im sum_q a_q e^{2 pi i q p}: v =
/// integral of a, x = integral of v, both with zero mean.
class BaseCycle {
public:
    /// From its acceleration; phase 0 is where harmonic 1 crosses zero upwards.
    explicit BaseCycle(const calibration::HarmonicFit& acceleration);
    [[nodiscard]] double a(double p) const noexcept { return sum(a_, p); }  // m/s^2
    [[nodiscard]] double v(double p) const noexcept { return sum(v_, p); }  // m/s
    [[nodiscard]] double x(double p) const noexcept { return sum(x_, p); }  // m
    /// The first start of a period at or after t.
    [[nodiscard]] double start_after(double t_s) const noexcept;
    [[nodiscard]] double period_s() const noexcept { return period_s_; }

private:
    using Terms = std::vector<std::complex<double>>;
    static double sum(const Terms& terms, double p) noexcept;
    Terms a_, v_, x_;
    double period_s_, start_s_;
};

/// A walker position at its phase, without drift and slow wandering between periods.
struct Folded {
    double phase;  // 0..1
    double x_m;    // periodic
    double sd_m;
};

/// All positions of all views, in order of phase.
std::vector<Folded> fold(std::span<const MotionSeries> walkers, const Drift& drift, double t0_s,
                         double frequency_hz);

/// Walker and base over one period at 50..200 phases (the frames' own phases when a period is a whole number
/// of frames).
/// x and v: quartic fitted to the samples at their true phases, over the width of the 7 nearest frames; on a
/// commensurate grid this is the 7-point quartic Savitzky-Golay filter. sd: from the scatter about the
/// quartic, kinks included. Bias of v beside a kink (jump da of acceleration): up to about 0.25 da / frame
/// rate; kinked_motion() has none.
struct SmoothedCycle {
    Cycle cycle;
    /// Median scatter about the quartics, in units of the positions' errors.
    double scale = 1;
};
SmoothedCycle smoothed_cycle(std::span<const Folded> folded, const BaseCycle& base, double v_D,
                             double frames_per_period);

}  // namespace shaker::reduction
