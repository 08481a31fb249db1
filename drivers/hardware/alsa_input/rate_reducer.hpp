#pragma once
// RateReducer: a linear-phase low-pass, evaluated at every n-th sample. Real-time after construction.
#include <array>
#include <cstddef>
#include <vector>

namespace shaker::alsa_input {

/// A sinc with a Kaiser window of beta 10 over 16 samples of the reduced rate. Flat to 2e-5 up to 0.3 of the
/// reduced rate; what folds back to below it is 2e-5 or less. Its delay is exact: eight samples of the
/// reduced rate, since the taps are symmetric. With n = 1 samples pass unchanged, without delay.
class RateReducer {
public:
    explicit RateReducer(int n);

    /// Samples of the input before the newest one at which the middle of the filter is.
    [[nodiscard]] int delay() const noexcept { return delay_; }
    /// Adds a sample of each axis.
    void add(const std::array<double, 3>& sample) noexcept;
    /// The filtered sample at `delay()` before the newest one. Valid after 2 delay() + 1 samples.
    [[nodiscard]] std::array<double, 3> value() const noexcept;

private:
    int delay_;
    std::vector<double> taps_;                     // sum 1
    std::array<std::vector<double>, 3> newest_{};  // twice as long as the taps: each sample stands twice
    std::size_t next_ = 0;
};

}  // namespace shaker::alsa_input
