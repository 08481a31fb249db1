#include "daemon/service/bench_port.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <utility>

namespace shaker::service {

// Counts first, so that no waiting order is carried out behind the stop. stop_() takes no lock.
std::uint64_t BenchPort::abort(const std::string& by) {
    ++aborted_;
    const std::uint64_t number = stop_();
    const auto now = state();
    log(now ? now->now_s : 0, "order", "abort by " + by, "abort");
    return number;
}

void BenchPort::order(Order order) {
    {
        const std::scoped_lock lock{mutex_};
        if (orders_.size() < most_orders) {
            ++ordered_;
            order.aborts = aborted_;
            if (auto* clear = std::get_if<ClearTrip>(&order.what))
                clear->shown = std::min(clear->shown, state_ ? state_->trips : 0);
            orders_.push_back(std::move(order));
            return;
        }
    }
    if (order.answer)
        order.answer(fmt::format("{} orders are waiting already; try again later", most_orders));
}

std::uint64_t BenchPort::ordered() const {
    const std::scoped_lock lock{mutex_};
    return ordered_;
}

std::shared_ptr<const BenchState> BenchPort::state() const {
    const std::scoped_lock lock{mutex_};
    return state_;
}

std::vector<BenchEvent> BenchPort::events(std::uint64_t seen) const {
    const std::scoped_lock lock{mutex_};
    return events_.since(seen);
}

std::optional<Order> BenchPort::next() {
    const std::scoped_lock lock{mutex_};
    if (orders_.empty()) return std::nullopt;
    std::optional<Order> order{std::move(orders_.front())};
    orders_.pop_front();
    return order;
}

void BenchPort::publish(std::shared_ptr<const BenchState> state) {
    const std::scoped_lock lock{mutex_};
    state_ = std::move(state);
    events_.show_counts(state_->now_s);
}

void BenchPort::log(double t_s, const std::string& kind, std::string text, std::string key) {
    const std::scoped_lock lock{mutex_};
    events_.add(t_s, kind, std::move(text), std::move(key));
}

}  // namespace shaker::service
