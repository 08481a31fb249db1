#pragma once
// Harmonics of the base's acceleration, one drive period at a time.
#include <array>
#include <cstdint>
#include <memory>

#include "drivers/drive.hpp"

namespace shaker {

/// What one period said. Invalid: the period was not seen whole (start, gap) or the fit has no solution.
struct HarmonicEstimate {
    Harmonics<Acceleration> harmonics;  // up to the order asked, against the phase given with the samples
    std::array<double, max_harmonics> sd{};  // standard deviation of Re and of Im of each (rms of both)
    double offset_mps2 = 0;                  // constant: gravity's part and the sensor's offset
    double rms_mps2 = 0;                     // what the harmonics do not explain
    int samples = 0;
    bool valid = false;
};

/// Least squares of {1, sin q theta, cos q theta, q = 1..order} on the samples of each period at their true
/// phases: the rate need not fit the period. One thread; add() does not allocate.
class HarmonicEstimator {
public:
    /// order 1..16; axis: the shaker's direction in sensor axes (any length but 0). Throws InputError.
    HarmonicEstimator(int order, const std::array<double, 3>& axis);
    ~HarmonicEstimator();
    HarmonicEstimator(HarmonicEstimator&&) noexcept;
    HarmonicEstimator& operator=(HarmonicEstimator&&) noexcept;

    /// One sample (m/s^2, sensor axes) at a phase of the drive; 2^64 is one turn. True when it is the first
    /// of a new period: estimate() then tells of the period before.
    bool add(std::uint64_t phase, const std::array<double, 3>& a) noexcept;
    /// Same with a phase in turns; only its fraction counts.
    bool add(double turns, const std::array<double, 3>& a) noexcept;
    /// Samples are missing or wrong: the period in hand will be invalid.
    void gap() noexcept;
    [[nodiscard]] const HarmonicEstimate& estimate() const noexcept;
    /// Covariance of that estimate's components, index 2(q-1) for Re and 2(q-1)+1 for Im of harmonic q.
    [[nodiscard]] double covariance(int i, int j) const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace shaker
