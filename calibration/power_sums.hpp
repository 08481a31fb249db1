#pragma once
// Streams of samples by blocks, and the sums over them from which normal equations follow.
#include <Eigen/Dense>
#include <array>
#include <complex>
#include <span>
#include <vector>

#include "calibration/harmonic_model.hpp"
#include "calibration/phasors.hpp"

namespace shaker {

/// One number for each sample of a block.
using BlockColumn = std::array<double, Phasors::size>;

/// Sum of products, in an order of its own that no compiler changes.
double dot(const BlockColumn& a, const BlockColumn& b) noexcept;

/// Up to a block of samples of one stream. Behind the last of them weights and values are zero.
struct SampleBlock {
    std::size_t count = 0;
    BlockColumn weight{};             // 1/sd^2
    Phasors z;                        // e^{i w (t - origin)}
    std::vector<BlockColumn> others;  // the slope's and the derivative's columns, where the model has them
    std::vector<BlockColumn> values;  // of each signal
};

/// Goes through a stream by blocks.
class Blocks {
public:
    Blocks(const HarmonicModel& model, std::span<const double> t, std::span<const double> sd,
           std::span<const std::span<const double>> signals);
    /// The next samples; null behind the last.
    const SampleBlock* next();

private:
    HarmonicModel m_;
    std::span<const double> t_, sd_;
    std::span<const std::span<const double>> signals_;
    std::vector<std::complex<double>> derivative_;
    std::size_t begin_ = 0;
    SampleBlock now_;
};

/// Weighted sums of z^k, alone and with the other columns and the signals: products of sines and cosines are
/// sums of sines and cosines, so that these are all that the normal equations need.
class PowerSums {
public:
    PowerSums(const HarmonicModel& m, std::size_t signals);
    void add(const SampleBlock& s) noexcept;
    [[nodiscard]] NormalEquations equations(const HarmonicModel& m) const;

private:
    /// Sum of w z^k, also for k < 0.
    [[nodiscard]] std::complex<double> power(int k) const {
        const auto z = alone_[static_cast<std::size_t>(std::abs(k))];
        return k < 0 ? std::conj(z) : z;
    }

    int order_;
    std::size_t others_;
    std::vector<std::complex<double>> alone_;  // by k up to 2 order
    // With the other columns, then with the signals; by k up to order.
    std::vector<std::vector<std::complex<double>>> with_;
    Eigen::MatrixXd products_;  // of the other columns with all of those
};

}  // namespace shaker
