#pragma once
// A fixed set of image buffers, handed out as shared pointers and returned by the last of them. Real-time.
#include <cstddef>
#include <cstdint>
#include <memory>

#include "drivers/data.hpp"

namespace shaker {

class FramePool {
public:
    /// `frames` buffers of the given size, taken from the heap and touched here. Throws InputError when a
    /// number is not positive.
    FramePool(int frames, int width, int height, int bytes_per_pixel);

    /// A buffer nobody else holds, its fields as in a new Frame of the pool's size, its pixels as they were
    /// left; or null (counted) when all are out. Any thread. The caller writes the pixels (without changing
    /// the size of the vector) and hands it on as a FramePtr. The last pointer returns the buffer, on any
    /// thread; frames may outlive the pool. Takes nothing from the heap and returns nothing to it while the
    /// pool lives.
    [[nodiscard]] std::shared_ptr<Frame> acquire() noexcept;
    /// How often there was no buffer left.
    [[nodiscard]] std::uint64_t exhausted() const noexcept;

private:
    struct Store;
    template <class T>
    class SlotAllocator;
    std::shared_ptr<Store> store_;  // every frame that is out holds it too
};

}  // namespace shaker
