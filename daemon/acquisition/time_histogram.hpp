#pragma once
// Histogram of short times. One real-time thread fills it, any thread reads it. No lock, no allocation.
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>

namespace shaker::acquisition {

class TimeHistogram {
public:
    /// Upper ends of the bins, s; one more bin holds larger values.
    static constexpr std::array ends_s{1e-6, 2e-6, 5e-6, 1e-5, 2e-5, 5e-5, 1e-4, 2e-4,
                                       5e-4, 1e-3, 2e-3, 5e-3, 1e-2, 2e-2, 5e-2, 1e-1};

    void add(double s) noexcept {
        std::size_t bin = 0;
        while (bin < ends_s.size() && s > ends_s[bin]) ++bin;
        counts_[bin].fetch_add(1, std::memory_order_relaxed);
        sum_s_ = sum_s_ + s;
        if (s > worst_s_) worst_s_ = s;
    }

    /// A reading. Each value is read separately, so the newest time may be in a count and not yet in the sum.
    struct Seen {
        std::array<std::uint64_t, ends_s.size() + 1> counts{};
        double sum_s = 0, worst_s = 0;
        [[nodiscard]] std::uint64_t total() const noexcept {
            std::uint64_t all = 0;
            for (const std::uint64_t n : counts) all += n;
            return all;
        }
        /// NaN before the first time was added.
        [[nodiscard]] double mean_s() const noexcept { return sum_s / static_cast<double>(total()); }
    };
    [[nodiscard]] Seen seen() const noexcept {
        Seen s{.sum_s = sum_s_, .worst_s = worst_s_};
        for (std::size_t i = 0; i < s.counts.size(); ++i) s.counts[i] = counts_[i];
        return s;
    }
    /// Upper bound of the times for the share p (0..1) of them, s: upper end of the bin; infinite in the last
    /// bin.
    [[nodiscard]] static double quantile(const Seen& seen, double p) noexcept {
        std::uint64_t below = 0;
        for (std::size_t i = 0; i < ends_s.size(); ++i) {
            below += seen.counts[i];
            if (static_cast<double>(below) >= p * static_cast<double>(seen.total())) return ends_s[i];
        }
        return INFINITY;
    }

private:
    std::array<std::atomic<std::uint64_t>, ends_s.size() + 1> counts_{};
    std::atomic<double> sum_s_{0}, worst_s_{0};
};

/// Deviations of the output's block periods from their nominal length.
class PeriodJitter : public TimeHistogram {
public:
    /// Adds a block taken at `now`; block_s: nominal duration of a block, s. The output's thread calls it
    /// after each block.
    void took(std::chrono::steady_clock::time_point now, double block_s) noexcept {
        const double since_s = std::chrono::duration<double>{now - last_}.count();
        const bool first = last_ == std::chrono::steady_clock::time_point{};
        last_ = now;
        if (!first) add(std::abs(since_s - block_s));
    }

private:
    std::chrono::steady_clock::time_point last_{};
};

}  // namespace shaker::acquisition
