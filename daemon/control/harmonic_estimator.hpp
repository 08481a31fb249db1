#pragma once
// Least squares of the accelerometer's harmonics against the drive's phase, one window of whole periods at a
// time.
#include <array>
#include <complex>
#include <cstdint>
#include <memory>
#include <optional>

#include "drivers/drive.hpp"

namespace shaker {

/// One window of the base as the accelerometer saw it. Amplitudes in m/s^2, phases against the drive.
struct PeriodEstimate {
    std::int64_t period = 0;  // whole turns of the drive's phase before it
    int periods = 1;          // of the window
    int samples = 0;
    Harmonics<Acceleration> along;                    // on the shaker's axis
    std::array<Harmonics<Acceleration>, 2> across{};  // on across_axes(axis)
    double sd = 0;                                    // of each amplitude's sine and cosine part, rms over q
    std::array<double, 3> axis{};                     // the shaker's axis in sensor axes
    std::array<double, 3> mean{};                     // gravity and offset, sensor axes
    std::complex<double> line = 0;  // of the mains, along the axis, phase at the window's start
    double residual = 0;            // rms along the axis of what is none of these

    /// Of `along`: covariance of component i with j, 2(q-1) for the sine part of harmonic q (the real part of
    /// its amplitude), 2(q-1)+1 for the cosine part; for white noise of the residual's size.
    [[nodiscard]] double covariance(int i, int j) const {
        return cov.at(static_cast<std::size_t>(i)).at(static_cast<std::size_t>(j));
    }
    std::array<std::array<double, 2UL * max_harmonics>, 2UL * max_harmonics> cov{};
};

struct EstimatorSettings {
    int harmonics = 8;             // K, 2..16
    int samples = 300;             // the most a window has
    std::array<double, 3> axis{};  // all 0: the direction in which harmonics 1 and 2 are strongest, with the
                                   // sign that makes its largest component positive, or the one of before
    int periods = 1;               // of a window
    std::array<double, 3> before{};  // where that direction was found before; all 0: nowhere
    double line = 0;                 // mains frequency over the drive's; 0: no line is fitted
};

/// Fewest whole periods in which a line at `ratio` times the drive's frequency can be told from harmonics
/// 1..K without making them noisier by more than a fifth: 1 without a line (ratio 0). 0 when the line is on a
/// harmonic, or so near that five periods are not enough: then it cannot be told from the motion.
int periods_to_tell(double ratio, int harmonics);

/// Gathers samples in order of their phase and fits {1, sin q theta, cos q theta, q = 1..K, line} to each
/// window. Memory is bounded by the longest window; nothing is allocated after construction.
class HarmonicEstimator {
public:
    explicit HarmonicEstimator(const EstimatorSettings& settings);
    ~HarmonicEstimator();
    HarmonicEstimator(HarmonicEstimator&&) noexcept;
    HarmonicEstimator& operator=(HarmonicEstimator&&) noexcept;

    /// A sample at `turns` of the drive's phase (never falling), m/s^2 in sensor axes. When it is the first
    /// of a new window, the estimate of the one before is returned, unless that one lacks samples (fewer than
    /// 3K a period, or a gap of more than a tenth of a period): incomplete data never become an estimate.
    std::optional<PeriodEstimate> add(double turns, const std::array<double, 3>& a);

private:
    struct Work;
    std::unique_ptr<Work> work_;
};

}  // namespace shaker
