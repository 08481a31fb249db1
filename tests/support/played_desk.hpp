#pragma once
// A desk with a bench behind it that does what it is told, has no devices, and moves when its turn comes.
#include <atomic>
#include <mutex>
#include <string>
#include <vector>

#include "daemon/desk.hpp"

namespace shaker::test {

class PlayedDesk {
public:
    PlayedDesk();
    PlayedDesk(const PlayedDesk&) = delete;
    PlayedDesk& operator=(const PlayedDesk&) = delete;

    Desk desk;
    std::atomic<int> aborts{0};
    /// While true nothing is answered.
    std::atomic<bool> deaf{false};
    /// Points of the waveform that is shown; 0: there is none.
    std::atomic<std::size_t> wave{0};
    /// Turns from one state that is shown to the next where nothing is ordered.
    static constexpr int shown_each = 20;
    /// What was ordered, in order.
    [[nodiscard]] std::vector<OrderWhat> ordered() const;
    /// Obeys all that was ordered; a millisecond goes by. One thread.
    void turn();

private:
    std::string obey(const OrderWhat& what);

    mutable std::mutex mutex_;
    std::vector<OrderWhat> ordered_;
    BenchState state_;
    int turns_ = 0;
};

}  // namespace shaker::test
