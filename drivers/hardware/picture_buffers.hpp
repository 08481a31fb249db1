#pragma once
// The memory that a GenICam stream writes into. Pictures that need no unpacking are received straight into
// frames of a pool, which are then handed on without a copy.
#include <cstddef>
#include <memory>
#include <vector>

#include "drivers/frame_pool.hpp"
#include "drivers/hardware/genicam_setup.hpp"

typedef struct _ArvBuffer ArvBuffer;  // NOLINT: Aravis' own names
typedef struct _ArvStream ArvStream;  // NOLINT

namespace shaker {

/// One thread at a time. Outlives every stream that its buffers are queued in. Once built, it takes no
/// memory.
class PictureBuffers {
public:
    /// `queued` pictures may wait in the stream, and about `given` may be with readers at a time.
    PictureBuffers(const GenicamPicture& picture, std::size_t queued, std::size_t given);
    ~PictureBuffers();
    PictureBuffers(const PictureBuffers&) = delete;
    PictureBuffers& operator=(const PictureBuffers&) = delete;

    /// Queues in the stream what is free. Fewer than `queued` when readers hold too many frames: then
    /// pictures are lost, which the gap before the next one shows.
    void queue(ArvStream* stream);
    /// A buffer that came out of the stream whole: its frame, whose fields the caller sets; null when no
    /// frame is free to unpack it into.
    std::shared_ptr<Frame> take(ArvBuffer* buffer);
    /// A buffer that came out broken.
    void discard(ArvBuffer* buffer) noexcept;
    /// The stream is gone: all its buffers are free.
    void reclaim() noexcept;

private:
    struct Slot {
        ArvBuffer* buffer = nullptr;    // keeps one reference
        const Frame* memory = nullptr;  // the frame it writes into, when it needs no unpacking
        std::shared_ptr<Frame> frame;   // while queued
        std::vector<std::byte> wire;    // what it writes into otherwise
        bool queued = false;
    };
    Slot& slot_of(ArvBuffer* buffer) noexcept;
    void push(Slot& slot, ArvStream* stream);

    const PixelFormat* format_;
    bool direct_;
    std::size_t depth_;
    std::size_t queued_ = 0;
    FramePool pool_;
    std::vector<Slot> slots_;  // direct: one for each frame of the pool, in order of `memory`
};

}  // namespace shaker
