#pragma once
// Blocks of samples and the sums over them from which normal equations follow.
#include <Eigen/Dense>
#include <array>
#include <complex>
#include <span>
#include <vector>

#include "calibration/harmonics/harmonic_model.hpp"
#include "calibration/harmonics/phasors.hpp"

namespace shaker::calibration {

/// One number per sample of a block.
using BlockColumn = std::array<double, Phasors::size>;

/// Sum of products in a fixed order, independent of the compiler.
double dot(const BlockColumn& a, const BlockColumn& b) noexcept;

/// Up to one block of samples of a stream. Unused weights and values are zero.
struct SampleBlock {
    std::size_t count = 0;
    BlockColumn weight{};             // 1/sd^2
    Phasors z;                        // e^{i w (t - origin)}
    std::vector<BlockColumn> others;  // columns of slope and derivative, if the model has them
    std::vector<BlockColumn> values;  // one per signal
};

/// Iterates over a stream in blocks.
class Blocks {
public:
    Blocks(const HarmonicModel& model, std::span<const double> t, std::span<const double> sd,
           std::span<const std::span<const double>> signals);
    /// The next block; null after the last.
    const SampleBlock* next();

private:
    HarmonicModel m_;
    std::span<const double> t_, sd_;
    std::span<const std::span<const double>> signals_;
    std::vector<std::complex<double>> derivative_;
    std::size_t begin_ = 0;
    SampleBlock now_;
};

/// Weighted sums of z^k, alone and multiplied by the other columns and the signals. Products of sines and
/// cosines are sums of sines and cosines, so the normal equations follow from these sums.
class PowerSums {
public:
    PowerSums(const HarmonicModel& m, std::size_t signals);
    void add(const SampleBlock& s) noexcept;
    [[nodiscard]] NormalEquations equations(const HarmonicModel& m) const;

private:
    /// Sum of w z^k; k may be negative.
    [[nodiscard]] std::complex<double> power(int k) const {
        const auto z = alone_[static_cast<std::size_t>(std::abs(k))];
        return k < 0 ? std::conj(z) : z;
    }

    int order_;
    std::size_t others_;
    std::vector<std::complex<double>> alone_;  // index k, 0..2 order
    // Multiplied by the other columns, then by the signals; index k, 0..order.
    std::vector<std::vector<std::complex<double>>> with_;
    Eigen::MatrixXd products_;  // of the other columns with themselves and the signals
};

}  // namespace shaker::calibration
