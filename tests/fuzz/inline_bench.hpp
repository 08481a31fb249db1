#pragma once
// A played desk and what stands before it in the daemon, on one thread: it moves when settle() is called.
#include <cstdlib>
#include <deque>
#include <functional>
#include <iostream>
#include <utility>

#include "daemon/order_book.hpp"
#include "daemon/remote/scpi/control_lock.hpp"
#include "tests/support/played_desk.hpp"

namespace shaker::test {

/// Ends the program, which libFuzzer takes for a finding.
inline void require(bool holds, const char* what) {
    if (holds) return;
    std::cerr << "does not hold: " << what << '\n';
    std::abort();
}

class InlineBench {
    std::deque<std::function<void()>> later_;

public:
    PlayedDesk played;
    scpi::ControlLock lock;
    OrderBook book{played.desk, [this](std::function<void()> f) { later_.push_back(std::move(f)); }};

    /// What was ordered is done and answered.
    void settle() {
        played.turn();
        while (!later_.empty()) {
            const auto next = std::move(later_.front());
            later_.pop_front();
            next();
        }
    }
};

}  // namespace shaker::test
