#pragma once
// Measured and predicted motion over the last quarter of a period. Real-time.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace shaker::safety {

/// Running sums over the newest samples. They are recomputed each time the window has been filled again,
/// so rounding errors do not accumulate.
class ResidualWindow {
public:
    static constexpr std::size_t most_samples = 2048;

    /// Clears the window and sets its length in samples (1..most_samples).
    void resize(std::size_t samples) noexcept {
        size_ = std::clamp<std::size_t>(samples, 1, most_samples);
        clear();
    }
    void clear() noexcept { filled_ = next_ = 0, mm_ = pp_ = mp_ = 0; }
    void add(double measured, double predicted) noexcept {
        const bool full = filled_ == size_;
        Pair& here = pairs_[next_];
        if (full) count(here, -1);
        here = {measured, predicted};
        count(here, 1);
        if (!full) ++filled_;
        if (++next_ < size_) return;
        next_ = 0;
        mm_ = pp_ = mp_ = 0;
        for (std::size_t i = 0; i < filled_; ++i) count(pairs_[i], 1);
    }
    [[nodiscard]] std::size_t size() const noexcept { return size_; }
    [[nodiscard]] bool full() const noexcept { return filled_ == size_; }
    /// Rms of the measured and the predicted motion and of their difference.
    [[nodiscard]] double measured() const noexcept { return root(mm_); }
    [[nodiscard]] double predicted() const noexcept { return root(pp_); }
    [[nodiscard]] double residual() const noexcept { return root(mm_ - 2 * mp_ + pp_); }
    /// Measured / predicted motion by least squares; 1 is ideal. 0 when no motion is predicted.
    [[nodiscard]] double gain() const noexcept { return pp_ > 0 ? mp_ / pp_ : 0; }

private:
    struct Pair {
        double measured = 0, predicted = 0;
    };
    void count(const Pair& p, double sign) noexcept {
        mm_ += sign * p.measured * p.measured;
        pp_ += sign * p.predicted * p.predicted;
        mp_ += sign * p.measured * p.predicted;
    }
    [[nodiscard]] double root(double sum) const noexcept {
        return filled_ > 0 ? std::sqrt(std::max(0.0, sum) / static_cast<double>(filled_)) : 0;
    }

    std::array<Pair, most_samples> pairs_{};
    std::size_t size_ = 1, filled_ = 0, next_ = 0;
    double mm_ = 0, pp_ = 0, mp_ = 0;
};

}  // namespace shaker::safety
