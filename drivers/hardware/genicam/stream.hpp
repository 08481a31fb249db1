#pragma once
// GenicamStream: one connection to a GenICam camera, from opening to loss. Sets it up, starts it, receives
// its pictures.
#include <chrono>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "drivers/frame_pool.hpp"
#include "drivers/hardware/clock/exposure_counter.hpp"
#include "drivers/hardware/genicam/setup.hpp"

typedef struct _ArvBuffer ArvBuffer;  // NOLINT: Aravis' own names
typedef struct _ArvStream ArvStream;  // NOLINT

namespace shaker::genicam {

/// Memory for a GenICam stream. Pictures that need no unpacking are received directly into frames of a pool,
/// which are passed on without a copy. One thread at a time. Must outlive every stream in which its buffers
/// are queued. No allocation after construction.
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

/// One buffer from the stream.
struct ReceivedPicture {
    bool whole = false;            // no packet is missing
    std::shared_ptr<Frame> frame;  // null when broken or when no frame was free
    hardware::ExposureSign sign;   // valid if `whole`
};

/// One thread, except where stated.
class GenicamStream {
public:
    /// Opens and configures; see open_genicam.
    GenicamStream(const GenicamSettings& settings, const std::string& name);
    /// Stops the camera and returns all buffers. May take seconds when the camera does not answer.
    ~GenicamStream();
    GenicamStream(const GenicamStream&) = delete;
    GenicamStream& operator=(const GenicamStream&) = delete;

    [[nodiscard]] const GenicamPicture& picture() const noexcept;
    /// Granted and refused settings, one line each.
    [[nodiscard]] const std::vector<std::string>& granted() const noexcept;
    /// Starts the camera. The buffers must outlive this object.
    void start(PictureBuffers& buffers);
    /// The next buffer; empty when none came within `wait`.
    std::optional<ReceivedPicture> receive(std::chrono::microseconds wait);
    /// Exposes one picture if triggered by software. False when the camera did not answer.
    bool trigger() noexcept;
    /// Marks the camera as dead: commands to it are omitted as far as possible, because each takes seconds.
    void forsake() noexcept;
    /// True when the camera does not answer any more, or another program took control. Any thread.
    [[nodiscard]] bool control_lost() const noexcept;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace shaker::genicam
