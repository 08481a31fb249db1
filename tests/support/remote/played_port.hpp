#pragma once
// A bench port that executes orders without devices, one step per call.
#include <atomic>
#include <mutex>
#include <string>
#include <vector>

#include "daemon/service/bench_port.hpp"

namespace shaker::test {

class PlayedPort {
public:
    PlayedPort();
    PlayedPort(const PlayedPort&) = delete;
    PlayedPort& operator=(const PlayedPort&) = delete;

    service::BenchPort bench_port;
    std::atomic<int> aborts{0};
    /// While true, orders are not answered.
    std::atomic<bool> deaf{false};
    /// While true, the output does not obey aborts.
    std::atomic<bool> hung{false};
    /// Steps until a trip is gone after its clear was accepted.
    std::atomic<int> clears_after{0};
    /// While true, the newest mu is one that the measurements refuse.
    std::atomic<bool> mu_refused{false};
    /// Points of the published waveform; 0: no waveform.
    std::atomic<std::size_t> wave{0};
    /// Steps between two published states while there is no order.
    static constexpr int shown_each = 20;
    /// All orders, oldest first.
    [[nodiscard]] std::vector<service::OrderWhat> ordered() const;
    /// Executes all orders and advances time by one millisecond. One thread.
    void turn();

private:
    std::string obey(const service::OrderWhat& what);
    void end_trip();

    std::atomic<std::uint64_t> obeyed_{0};
    mutable std::mutex mutex_;
    std::vector<service::OrderWhat> ordered_;
    service::BenchState state_;
    int turns_ = 0, clears_in_ = -1;  // steps; negative: no trip is being cleared
};

}  // namespace shaker::test
