#include "daemon/service/bench_port.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <utility>

namespace shaker::service {

void LiveSeries::add(double t_s, std::span<const float> values) {
    const std::scoped_lock lock{mutex_};
    if (t_s_.size() < most_) {
        t_s_.push_back(t_s);
        values_.insert(values_.end(), values.begin(), values.end());
    } else {
        const std::size_t at = count_ % most_;
        t_s_[at] = t_s;
        std::ranges::copy(values, values_.begin() + static_cast<std::ptrdiff_t>(at * channels_));
    }
    ++count_;
}

LiveSeries::Part LiveSeries::since(std::uint64_t from) const {
    const std::scoped_lock lock{mutex_};
    const std::uint64_t oldest = count_ - std::min<std::uint64_t>(count_, most_);
    Part part;
    part.gap = from < oldest;
    part.first = std::clamp(from, oldest, count_);
    for (std::uint64_t k = part.first; k < count_; ++k) {
        const std::size_t at = k % most_;
        part.t_s.push_back(t_s_[at]);
        for (std::size_t c = 0; c < channels_; ++c) part.values.push_back(values_[at * channels_ + c]);
    }
    return part;
}

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
            at_rest_ = false;
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
    const bool measures = state_->campaign && state_->campaign->active && !state_->campaign->paused;
    const bool comes = state_->orders_wait || state_->state == run::RunState::armed;
    at_rest_ = orders_.empty() && !measures && !comes && !driving(state_->state);
    events_.show_counts(state_->now_s);
}

void BenchPort::log(double t_s, const std::string& kind, std::string text, std::string key) {
    const std::scoped_lock lock{mutex_};
    events_.add(t_s, kind, std::move(text), std::move(key));
}

}  // namespace shaker::service
