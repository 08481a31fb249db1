#pragma once
// The two ways to pass values between threads: a Ring keeps every value in order, a Mailbox keeps the
// newest. Neither waits or locks; memory is allocated in the constructor only. Real-time.
#include <array>
#include <atomic>
#include <boost/lockfree/spsc_queue.hpp>
#include <cstddef>
#include <optional>
#include <type_traits>
#include <utility>

namespace shaker {

/// Bounded queue from one writing thread to one reading thread. T is copied in and moved out; resources
/// of a value are released at pop().
template <class T>
class Ring {
public:
    /// Reserves room for `capacity` values (>= 1).
    explicit Ring(std::size_t capacity) : queue_{capacity} {}

    /// False when the queue is full: the value is not stored and the caller counts it as lost.
    /// Writer's thread only.
    [[nodiscard]] bool push(const T& value) noexcept(std::is_nothrow_copy_constructible_v<T>) {
        return queue_.push(value);
    }
    /// True when the next push() would fail. Writer's thread only.
    [[nodiscard]] bool full() const noexcept { return queue_.write_available() == 0; }
    /// True when there is no value to pop(). Reader's thread only.
    [[nodiscard]] bool empty() const noexcept { return queue_.read_available() == 0; }
    /// The oldest value; empty when the ring is empty. Reader's thread only.
    [[nodiscard]] std::optional<T> pop() noexcept(std::is_nothrow_move_constructible_v<T>) {
        std::optional<T> value;
        queue_.consume_one([&](T& oldest) { value.emplace(std::move(oldest)); });
        return value;
    }

private:
    boost::lockfree::spsc_queue<T> queue_;
};

/// Passes the newest value from one writing thread to one reading thread; a value that was not read is
/// overwritten. Wait-free on both sides for any size of T. Of three slots the writer owns one, the reader
/// one; the third is exchanged.
template <class T>
class Mailbox {
    static_assert(std::is_trivially_copyable_v<T>);

public:
    /// Stores a value for the reader. Writer's thread only.
    void post(const T& value) noexcept {
        slots_[writers_].value = value;
        writers_ = middle_.exchange(writers_ | fresh, std::memory_order_acq_rel) & index;
    }
    /// The newest value, once. Empty when nothing was posted since the last take(). Reader's thread
    /// only.
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
