#pragma once
// The only two ways across threads: a Ring keeps every value in order, a Mailbox keeps the newest. Neither
// waits, locks or, once built, takes memory. Real-time.
#include <array>
#include <atomic>
#include <boost/lockfree/spsc_queue.hpp>
#include <cstddef>
#include <optional>
#include <type_traits>
#include <utility>

namespace shaker {

/// Bounded queue from one thread to one other. T is copied in and moved out; what it owns is released at
/// pop().
template <class T>
class Ring {
public:
    /// Holds `capacity` values (>= 1), reserved here.
    explicit Ring(std::size_t capacity) : queue_{capacity} {}

    /// False when full: the value was not taken and the caller counts it as lost. Writer's thread only.
    [[nodiscard]] bool push(const T& value) noexcept(std::is_nothrow_copy_constructible_v<T>) {
        return queue_.push(value);
    }
    /// Whether the next push() would fail. Writer's thread only.
    [[nodiscard]] bool full() const noexcept { return queue_.write_available() == 0; }
    /// Whether there is nothing to pop(). Reader's thread only.
    [[nodiscard]] bool empty() const noexcept { return queue_.read_available() == 0; }
    /// The oldest value, or empty. Reader's thread only.
    [[nodiscard]] std::optional<T> pop() noexcept(std::is_nothrow_move_constructible_v<T>) {
        std::optional<T> value;
        queue_.consume_one([&](T& oldest) { value.emplace(std::move(oldest)); });
        return value;
    }

private:
    boost::lockfree::spsc_queue<T> queue_;
};

/// The newest value from one thread for one other; older ones that were not taken are gone. Wait-free on both
/// sides, whatever the size of T. Three slots: the writer owns one, the reader one, one changes hands.
template <class T>
class Mailbox {
    static_assert(std::is_trivially_copyable_v<T>);

public:
    /// Leaves a value for the reader. Writer's thread only.
    void post(const T& value) noexcept {
        slots_[writers_].value = value;
        writers_ = middle_.exchange(writers_ | fresh, std::memory_order_acq_rel) & index;
    }
    /// The newest value, once; empty when nothing was posted since the last take(). Reader's thread only.
    [[nodiscard]] std::optional<T> take() noexcept {
        if ((middle_.load(std::memory_order_relaxed) & fresh) == 0) return std::nullopt;
        readers_ = middle_.exchange(readers_, std::memory_order_acq_rel) & index;
        return slots_[readers_].value;
    }

private:
    static constexpr unsigned index = 3;
    static constexpr unsigned fresh = 4;
    static constexpr std::size_t cache_line = 64;

    struct alignas(cache_line) Slot {
        T value{};
    };
    std::array<Slot, 3> slots_;
    alignas(cache_line) unsigned writers_ = 0;
    alignas(cache_line) unsigned readers_ = 1;
    alignas(cache_line) std::atomic<unsigned> middle_{2};
};

}  // namespace shaker
