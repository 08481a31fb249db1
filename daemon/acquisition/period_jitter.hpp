#pragma once
// Histogram of the deviations of the output's block periods from their nominal length. The real-time thread
// fills it, any thread reads it.
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>

namespace shaker::acquisition {

class PeriodJitter {
public:
    /// Upper ends of the bins, s; one more bin holds larger values.
    static constexpr std::array ends_s{1e-6, 2e-6, 5e-6, 1e-5, 2e-5, 5e-5, 1e-4, 2e-4,
                                       5e-4, 1e-3, 2e-3, 5e-3, 1e-2, 2e-2, 5e-2, 1e-1};

    /// Adds a block taken at `now`; block_s: nominal duration of a block, s. The output's thread calls it
    /// after each block. No lock, no allocation.
    void took(std::chrono::steady_clock::time_point now, double block_s) noexcept {
        const double since_s = std::chrono::duration<double>{now - last_}.count();
        const bool first = last_ == std::chrono::steady_clock::time_point{};
        last_ = now;
        if (first) return;
        const double off_s = std::abs(since_s - block_s);
        std::size_t bin = 0;
        while (bin < ends_s.size() && off_s > ends_s[bin]) ++bin;
        counts_[bin].fetch_add(1, std::memory_order_relaxed);
        sum_s_ = sum_s_ + off_s;
        if (off_s > worst_s_) worst_s_ = off_s;
    }

    /// A reading. Each value is read separately, so the newest block may be in a count and not yet in the
    /// sum.
    struct Seen {
        std::array<std::uint64_t, ends_s.size() + 1> counts{};
        double sum_s = 0, worst_s = 0;
    };
    [[nodiscard]] Seen seen() const noexcept {
        Seen s{.sum_s = sum_s_, .worst_s = worst_s_};
        for (std::size_t i = 0; i < s.counts.size(); ++i) s.counts[i] = counts_[i];
        return s;
    }
    /// Upper bound of the deviation for the share p (0..1) of the periods, s: upper end of the bin; infinite
    /// in the last bin.
    [[nodiscard]] static double quantile(const Seen& seen, double p) noexcept {
        std::uint64_t all = 0, below = 0;
        for (const std::uint64_t n : seen.counts) all += n;
        for (std::size_t i = 0; i < ends_s.size(); ++i) {
            below += seen.counts[i];
            if (static_cast<double>(below) >= p * static_cast<double>(all)) return ends_s[i];
        }
        return INFINITY;
    }

private:
    std::chrono::steady_clock::time_point last_{};
    std::array<std::atomic<std::uint64_t>, ends_s.size() + 1> counts_{};
    std::atomic<double> sum_s_{0}, worst_s_{0};
};

}  // namespace shaker::acquisition
