#pragma once
// What clients want of the bench, as it will be once all that was ordered is done: on the thread that serves
// them.
#include <functional>
#include <memory>
#include <string>

#include "daemon/service/bench_port.hpp"

namespace shaker::service {

class PendingOrders {
public:
    /// later: runs a function on this thread, from any other; not when this is gone, which it outlives in
    /// copies.
    using Later = std::function<void(std::function<void()>)>;
    PendingOrders(BenchPort& bench_port, Later later) : bench_port_{bench_port}, later_{std::move(later)} {}

    /// The newest state; null before the first.
    [[nodiscard]] std::shared_ptr<const BenchState> now() const { return bench_port_.state(); }
    /// What is wanted, with all orders under way.
    [[nodiscard]] Drive drive() const;
    [[nodiscard]] int periods() const;
    [[nodiscard]] safety::Limits limits() const;
    /// An order or an abort is under way, or what it began is: a ramp, an identification, a stop.
    [[nodiscard]] bool pending() const;

    /// Orders; answered(why) is called on this thread, once, with why it was refused, or empty.
    using Answered = std::function<void(const std::string& refused)>;
    void order(OrderWhat what, Answered answered);
    void abort(const std::string& by) { bench_port_.abort(by); }
    [[nodiscard]] BenchPort& bench_port() noexcept { return bench_port_; }

private:
    BenchPort& bench_port_;
    Later later_;
    std::size_t under_way_ = 0;
    Drive drive_;  // the last that was ordered
    safety::Limits limits_;
};

}  // namespace shaker::service
