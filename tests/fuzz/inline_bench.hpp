#pragma once
// A simulated bench port with the daemon's queue of orders, in one thread. settle() executes the orders.
#include <cstdlib>
#include <deque>
#include <functional>
#include <iostream>
#include <utility>

#include "daemon/remote/access/access.hpp"
#include "daemon/service/pending_orders.hpp"
#include "tests/support/remote/played_port.hpp"

namespace shaker::test {

/// Ends the program if `holds` is false; libFuzzer counts that as a finding.
inline void require(bool holds, const char* what) {
    if (holds) return;
    std::cerr << "does not hold: " << what << '\n';
    std::abort();
}

class InlineBench {
    std::deque<std::function<void()>> later_;

public:
    PlayedPort played;
    access::ControlLock lock;
    access::Aborts aborts{{.stop = [this](const std::string& by) { return played.bench_port.abort(by); },
                           .obeyed = [this] { return played.bench_port.obeyed(); }}};
    service::PendingOrders pending_orders{
        played.bench_port, [this](std::function<void()> f) { later_.push_back(std::move(f)); }};

    /// Executes and answers all orders.
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
