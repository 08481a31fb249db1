#pragma once
// Sums for least squares of harmonics, computed once: fits with other weights or fewer harmonics then cost
// almost nothing.
#include <vector>

#include "calibration/harmonics/harmonic_fit.hpp"

namespace shaker::calibration {

/// Refers to its samples, which must outlive it. Sums are accumulated in blocks, in an order that depends
/// only on the samples.
class HarmonicSums {
public:
    /// Sums for harmonics 1..order of these streams.
    HarmonicSums(std::span<const HarmonicSamples> streams, double frequency_hz, int order, Slope slope);

    /// Fits harmonics 1..order (at most those of the constructor). The standard deviations of stream k are
    /// multiplied by scale[k] (empty: 1). Throws as fit_harmonics() does.
    [[nodiscard]] HarmonicFit fit(int order, std::span<const double> scale = {}) const;
    /// The sums of one stream alone.
    [[nodiscard]] HarmonicSums of_stream(std::size_t k) const;
    [[nodiscard]] int order() const noexcept { return order_; }
    [[nodiscard]] std::size_t streams() const noexcept { return streams_.size(); }

private:
    struct Stream {
        HarmonicSamples samples;
        double weight = 0, weighted_t = 0;  // sums of 1/sd^2 and t/sd^2
        std::vector<double> normal, right;  // of sin and cos of each harmonic, slope, constant; lower half
    };
    double frequency_hz_, origin_s_ = 0, half_span_s_ = 0;
    int order_;
    Slope slope_;
    std::vector<Stream> streams_;
};

}  // namespace shaker::calibration
