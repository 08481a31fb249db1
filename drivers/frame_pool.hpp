#pragma once
// A fixed set of image buffers, handed out as shared pointers. Releasing the last pointer returns the
// buffer. Real-time.
#include <cstddef>
#include <cstdint>
#include <memory>

#include "drivers/data.hpp"

namespace shaker {

class FramePool {
public:
    /// Allocates `frames` buffers of the given size and touches their pages. Throws InputError when a
    /// number is not positive.
    FramePool(int frames, int width, int height, int bytes_per_pixel);

    /// A free buffer, or null (counted) when all are in use. Any thread. Its fields are those of a
    /// new Frame of the pool's size; its pixels keep their old values. The caller writes the pixels
    /// without resizing the vector and passes the frame on as a FramePtr. Releasing the last pointer,
    /// on any thread, returns the buffer. Frames may outlive the pool. Neither allocates nor frees
    /// memory while the pool lives.
    [[nodiscard]] std::shared_ptr<Frame> acquire() noexcept;
    /// Number of calls of acquire() that found no free buffer.
    [[nodiscard]] std::uint64_t exhausted() const noexcept;

private:
    struct Store;
    template <class T>
    class SlotAllocator;
    std::shared_ptr<Store> store_;  // shared with every frame in use
};

}  // namespace shaker
