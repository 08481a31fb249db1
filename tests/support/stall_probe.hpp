#pragma once
// StallProbe: a thread that sleeps beside a measurement in real time and notes when the machine stood still.
#include <algorithm>
#include <chrono>
#include <mutex>
#include <thread>
#include <vector>

namespace shaker::test {

class StallProbe {
public:
    using Clock = std::chrono::steady_clock;

    /// A sleep that ends later than this counts as a stall. A measurement that meets one says nothing about
    /// the program.
    static constexpr std::chrono::milliseconds least{20};

    /// Longest stall that overlaps the time from `from` to `to`, s. 0: none.
    [[nodiscard]] double longest_s(Clock::time_point from, Clock::time_point to) const {
        const std::scoped_lock lock{mutex_};
        double longest = 0;
        for (const auto& [begin, end] : stalls_)
            if (begin < to && end > from)
                longest = std::max(longest, std::chrono::duration<double>{end - begin}.count());
        return longest;
    }
    /// Longest stall so far, s.
    [[nodiscard]] double longest_s() const { return longest_s({}, Clock::time_point::max()); }

private:
    static constexpr std::chrono::milliseconds nap{5};
    mutable std::mutex mutex_;
    std::vector<std::pair<Clock::time_point, Clock::time_point>> stalls_{};
    std::jthread thread_{[this](const std::stop_token& stop) {
        while (!stop.stop_requested()) {
            const auto begin = Clock::now();
            std::this_thread::sleep_for(nap);
            const auto end = Clock::now();
            if (end - begin < nap + least) continue;
            const std::scoped_lock lock{mutex_};
            stalls_.emplace_back(begin + nap, end);
        }
    }};
};

}  // namespace shaker::test
