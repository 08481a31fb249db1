#pragma once
// The sums that least squares of harmonics need, gathered once: fits with other weights or fewer harmonics
// then cost next to nothing.
#include <vector>

#include "calibration/harmonic_fit.hpp"

namespace shaker {

/// Refers to the samples it was gathered from, which outlive it. Sums are taken by blocks, in an order that
/// depends on the samples alone.
class HarmonicSums {
public:
    /// For harmonics 1..order of these streams.
    HarmonicSums(std::span<const HarmonicSamples> streams, double frequency_hz, int order, Slope slope);

    /// Fits harmonics 1..order (at most those gathered), the standard deviations of stream k multiplied by
    /// scale[k] (empty: as they are). Throws as fit_harmonics() does.
    [[nodiscard]] HarmonicFit fit(int order, std::span<const double> scale = {}) const;
    /// Those of one stream alone.
    [[nodiscard]] HarmonicSums of_stream(std::size_t k) const;
    [[nodiscard]] int order() const noexcept { return order_; }
    [[nodiscard]] std::size_t streams() const noexcept { return streams_.size(); }

private:
    struct Stream {
        HarmonicSamples samples;
        double weight = 0, weighted_t = 0;  // sums of 1/sd^2 and t/sd^2
        std::vector<double> normal, right;  // of sin, cos of each harmonic, slope, constant; lower half
    };
    double frequency_hz_, origin_s_ = 0, half_span_s_ = 0;
    int order_;
    Slope slope_;
    std::vector<Stream> streams_;
};

}  // namespace shaker
