#include "drivers/frame_pool.hpp"

#include <array>
#include <atomic>
#include <new>
#include <string>
#include <utility>
#include <vector>

#include "drivers/errors.hpp"

namespace shaker {
namespace {

struct Slot {
    Frame frame;
    std::atomic<bool> out = false;
    alignas(std::max_align_t) std::array<std::byte, 128> control;  // of the shared pointer
};

void require_positive(const char* what, int value) {
    if (value < 1)
        throw InputError{std::string{"frame pool: "} + what + " is " + std::to_string(value) +
                         ", must be positive"};
}

}  // namespace

struct FramePool::Store {
    std::vector<Slot> slots;
    std::atomic<std::uint64_t> exhausted = 0;
    explicit Store(std::size_t frames) : slots(frames) {}
};

/// Places the shared pointer's control block inside the slot. The slot is free when the control block is
/// destroyed, that is after the last weak pointer too.
template <class T>
class FramePool::SlotAllocator {
public:
    using value_type = T;
    SlotAllocator(std::shared_ptr<Store> store, Slot& slot) noexcept
        : store_{std::move(store)}, slot_{&slot} {}
    template <class U>
    SlotAllocator(const SlotAllocator<U>& other) noexcept : store_{other.store_}, slot_{other.slot_} {}

    T* allocate(std::size_t) noexcept {
        static_assert(sizeof(T) <= sizeof(Slot::control) && alignof(T) <= alignof(std::max_align_t));
        return reinterpret_cast<T*>(slot_->control.data());
    }
    void deallocate(T*, std::size_t) noexcept { slot_->out.store(false, std::memory_order_release); }
    template <class U>
    bool operator==(const SlotAllocator<U>& other) const noexcept {
        return slot_ == other.slot_;
    }

private:
    template <class U>
    friend class FramePool::SlotAllocator;
    std::shared_ptr<Store> store_;
    Slot* slot_;
};

FramePool::FramePool(int frames, int width, int height, int bytes_per_pixel) {
    require_positive("number of frames", frames);
    require_positive("width", width);
    require_positive("height", height);
    require_positive("bytes a pixel", bytes_per_pixel);
    store_ = std::make_shared<Store>(static_cast<std::size_t>(frames));
    const auto bytes = static_cast<std::size_t>(width) * static_cast<std::size_t>(height) *
                       static_cast<std::size_t>(bytes_per_pixel);
    for (Slot& slot : store_->slots) {
        slot.frame.width = width;
        slot.frame.height = height;
        slot.frame.bytes_per_pixel = bytes_per_pixel;
        slot.frame.pixels.resize(bytes);
    }
}

std::shared_ptr<Frame> FramePool::acquire() noexcept {
    // A linear search of a few dozen flags costs less than one row of a frame and needs no free list.
    for (Slot& slot : store_->slots) {
        if (slot.out.exchange(true, std::memory_order_acquire)) continue;
        slot.frame.tick = {};
        slot.frame.arrived = {};
        slot.frame.stamp.reset();
        slot.frame.mid_exposure.reset();
        slot.frame.quality = {};
        return {&slot.frame, [](Frame*) {}, SlotAllocator<Frame>{store_, slot}};
    }
    store_->exhausted.fetch_add(1, std::memory_order_relaxed);
    return nullptr;
}

std::uint64_t FramePool::exhausted() const noexcept {
    return store_->exhausted.load(std::memory_order_relaxed);
}

}  // namespace shaker
