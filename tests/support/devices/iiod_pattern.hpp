#pragma once
// Samples that contain their own number, fed to a mock iiod in real time: the losses of a client are known
// exactly.
#include <array>
#include <atomic>
#include <cstdint>
#include <thread>

#include "tests/mock/iiod.hpp"

namespace shaker::test {

/// Counts of 20 bits, of both signs, from which numbered() finds n; 0 <= n < 2^36.
constexpr std::array<std::int32_t, 3> pattern(std::int64_t n) noexcept {
    const auto low = static_cast<std::int32_t>(n & 0x3ffff);
    return {low, static_cast<std::int32_t>(n >> 18), -low};
}
/// The number of a sample, or -1 if the counts do not match the pattern.
constexpr std::int64_t numbered(const std::array<std::int32_t, 3>& counts) noexcept {
    const bool ours = counts[0] >= 0 && counts[1] >= 0 && counts[2] == -counts[0];
    return ours ? (std::int64_t{counts[1]} << 18) + counts[0] : -1;
}

/// A thread pushes the pattern at the rate until destruction. The stamp of sample n is its due time on the
/// monotonic clock, exactly n steps after the first.
class PatternFeeder {
public:
    PatternFeeder(mock::Iiod& iiod, double rate_hz);

    /// Samples pushed so far.
    [[nodiscard]] std::int64_t pushed() const noexcept { return pushed_; }
    /// Stamp of sample 0.
    [[nodiscard]] std::int64_t first_stamp_ns() const noexcept { return first_ns_; }

private:
    void run(const std::stop_token& stop, mock::Iiod& iiod);

    double step_ns_;
    std::int64_t first_ns_;
    std::atomic<std::int64_t> pushed_{0};
    std::jthread thread_;
};

}  // namespace shaker::test
