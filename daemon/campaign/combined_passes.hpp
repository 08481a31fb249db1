#pragma once
// Harmonics and cycle from the passes of a point, with the weights of their drift (reduction/series.hpp).
#include <span>

#include "daemon/reduction/reduction.hpp"
#include "daemon/reduction/series.hpp"

namespace shaker::campaign {

/// Mean of complex amplitudes; NaN for a harmonic that a pass does not have.
reduction::MeasuredHarmonic weighted(int q, std::span<const reduction::Reduction* const> passes,
                                     std::span<const double> weights);

inline constexpr int cycle_phases = 100;
/// The cycle at phases 0, 0.01, ... 0.99, by cubic interpolation, with x = 0 at phase 0. v_D: of the pass.
/// Empty when the cycle has fewer than 8 phases.
reduction::Cycle resampled(const reduction::Cycle& cycle, double drift_per_period_m);
/// Mean of cycles with equal phases.
reduction::Cycle weighted(std::span<const reduction::Cycle> cycles, std::span<const double> weights);

}  // namespace shaker::campaign
