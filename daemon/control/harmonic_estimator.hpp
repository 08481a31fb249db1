#pragma once
// HarmonicEstimator: least-squares fit of the accelerometer's harmonics to the drive's phase, for windows
// of whole periods.
#include <array>
#include <complex>
#include <cstdint>
#include <memory>
#include <optional>

#include "drivers/drive.hpp"

namespace shaker::control {

/// One window of the base's motion from the accelerometer. Amplitudes in m/s^2, phases relative to the
/// drive.
struct PeriodEstimate {
    std::int64_t period = 0;  // number of whole turns of the drive's phase before the window
    int periods = 1;          // length of the window
    int samples = 0;
    Harmonics<Acceleration> along;                    // on the shaker's axis
    std::array<Harmonics<Acceleration>, 2> across{};  // on across_axes(axis)
    double sd = 0;                 // sd of the sine or cosine part of an amplitude, rms over q
    std::array<double, 3> axis{};  // shaker axis in sensor axes, unit vector
    /// Gravity (specific force) and offset, sensor axes; see AccelerometerInfo::acceleration.
    std::array<double, 3> mean{};
    std::complex<double> line = 0;  // amplitude of the mains line along the axis, phase at the window's start
    double residual = 0;            // rms of the residual along the axis

    /// Covariance of components i and j of `along`, (m/s^2)^2: 2(q-1) is the sine part of harmonic q
    /// (real part of its amplitude), 2(q-1)+1 the cosine part. Assumes white noise of the residual's
    /// size.
    [[nodiscard]] double covariance(int i, int j) const {
        return cov.at(static_cast<std::size_t>(i)).at(static_cast<std::size_t>(j));
    }
    std::array<std::array<double, 2UL * max_harmonics>, 2UL * max_harmonics> cov{};
};

/// Samples of the accelerometer that a window needs, for each of its periods.
constexpr int least_samples(int harmonics) { return 3 * harmonics; }

struct EstimatorSettings {
    int harmonics = 8;             // K, 2..16
    int samples = 300;             // largest number of samples per window
    std::array<double, 3> axis{};  // all 0: the direction in which harmonics 1 and 2 are strongest. Its sign
                                   // follows `before` or, without it, makes the largest component positive
    int periods = 1;               // window length
    std::array<double, 3> before{};  // the direction found earlier; all 0: none
    double line = 0;                 // mains frequency / drive frequency; 0: no line is fitted
};

/// Fewest whole periods (1..5) in which a line at `ratio` times the drive's frequency is separable from
/// harmonics 1..K while their noise rises by at most a fifth. 1 without a line (ratio 0). 0 if the line
/// coincides with a harmonic, or is so near that five periods are not enough: it cannot be separated from
/// the motion.
int periods_to_tell(double ratio, int harmonics);

/// Fits, for each window and sensor axis, a = m + sum_{q=1..K} (s_q sin q theta + c_q cos q theta) +
/// line, where theta is the drive's phase and m the mean (gravity and offset). The amplitude of harmonic
/// q is s_q + i c_q, projected on the shaker's axis and across it. Unweighted: the noise is assumed
/// white. Memory is bounded by the longest window; no allocation after construction.
class HarmonicEstimator {
public:
    explicit HarmonicEstimator(const EstimatorSettings& settings);
    ~HarmonicEstimator();
    HarmonicEstimator(HarmonicEstimator&&) noexcept;
    HarmonicEstimator& operator=(HarmonicEstimator&&) noexcept;

    /// Adds a sample in m/s^2, sensor axes, at `turns` of the drive's phase (must not decrease). The
    /// first sample of a new window returns the estimate of the window before, unless that window is
    /// incomplete: fewer than 3K samples per period, or a gap of more than a tenth of a period.
    std::optional<PeriodEstimate> add(double turns, const std::array<double, 3>& a);

    /// The shaker's direction, whose sign later windows follow; all 0: not found yet. One window does not
    /// change it to another one.
    [[nodiscard]] const std::array<double, 3>& direction() const noexcept;

private:
    struct Work;
    std::unique_ptr<Work> work_;
};

}  // namespace shaker::control
