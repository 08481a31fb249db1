#pragma once
// Least squares of the accelerometer's harmonics against the drive's phase, one period at a time.
#include <array>
#include <complex>
#include <cstdint>
#include <memory>
#include <optional>

#include "drivers/drive.hpp"

namespace shaker {

/// One period of the base as the accelerometer saw it.
struct PeriodEstimate {
    std::int64_t period = 0;  // whole turns of the drive's phase before it
    int samples = 0;
    Harmonics<Acceleration> along;  // on the shaker's axis, phases against the drive
    double sd = 0;                  // standard deviation of each amplitude, m/s^2, from the residual
    std::array<double, 3> axis{};   // the axis they are along, sensor axes
};

/// Gathers samples in order of their phase and fits {1, sin q theta, cos q theta, q = 1..K} to each period.
/// Memory is bounded by the longest period; nothing is allocated after construction.
class HarmonicEstimator {
public:
    /// harmonics: K, 2..16. samples: the most a period has. axis: all 0 = the direction in which harmonics 1
    /// and 2 are strongest, with the sign that makes its largest component positive.
    HarmonicEstimator(int harmonics, int samples, std::array<double, 3> axis);
    ~HarmonicEstimator();
    HarmonicEstimator(HarmonicEstimator&&) noexcept;
    HarmonicEstimator& operator=(HarmonicEstimator&&) noexcept;

    /// A sample at `turns` of the drive's phase (never falling), m/s^2 in sensor axes. When it is the first
    /// of a new period, the estimate of the one before is returned, unless that one lacks samples (fewer than
    /// 3K, or a gap of more than a tenth of a period): incomplete data never become an estimate.
    std::optional<PeriodEstimate> add(double turns, const std::array<double, 3>& a);

private:
    struct Work;
    std::unique_ptr<Work> work_;
};

}  // namespace shaker
