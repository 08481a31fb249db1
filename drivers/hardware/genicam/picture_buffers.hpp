#pragma once
// PictureBuffers: memory for a GenICam stream. Pictures that need no unpacking are received directly into
// frames of a pool, which are passed on without a copy.
#include <cstddef>
#include <memory>
#include <vector>

#include "drivers/frame_pool.hpp"
#include "drivers/hardware/genicam/setup.hpp"

typedef struct _ArvBuffer ArvBuffer;  // NOLINT: Aravis' own names
typedef struct _ArvStream ArvStream;  // NOLINT

namespace shaker::genicam {

/// One thread at a time. Must outlive every stream in which its buffers are queued. No allocation after
/// construction.
class PictureBuffers {
public:
    /// queued: pictures that may wait in the stream; given: approximate number of frames held by readers.
    PictureBuffers(const GenicamPicture& picture, std::size_t queued, std::size_t given);
    ~PictureBuffers();
    PictureBuffers(const PictureBuffers&) = delete;
    PictureBuffers& operator=(const PictureBuffers&) = delete;

    /// Queues all free buffers. When readers hold too many frames, fewer than `queued` are left and pictures
    /// are lost; the gap before the next one shows it.
    void queue(ArvStream* stream);
    /// The frame of a complete buffer from the stream; the caller sets its fields. Null when no frame is free
    /// to unpack it into.
    std::shared_ptr<Frame> take(ArvBuffer* buffer);
    /// Returns an incomplete buffer.
    void discard(ArvBuffer* buffer) noexcept;
    /// Call after the stream is destroyed: all its buffers are free.
    void reclaim() noexcept;

private:
    struct Slot {
        ArvBuffer* buffer = nullptr;    // holds one reference
        const Frame* memory = nullptr;  // the frame it writes into, if no unpacking is needed
        std::shared_ptr<Frame> frame;   // while queued
        std::vector<std::byte> wire;    // the memory it writes into otherwise
        bool queued = false;
    };
    Slot& slot_of(ArvBuffer* buffer) noexcept;
    void push(Slot& slot, ArvStream* stream);

    const PixelFormat* format_;
    bool direct_;
    std::size_t depth_;
    std::size_t queued_ = 0;
    FramePool pool_;
    std::vector<Slot> slots_;  // direct: one per frame of the pool, in order of `memory`
};

}  // namespace shaker::genicam
