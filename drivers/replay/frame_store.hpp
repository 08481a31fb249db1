#pragma once
// Pictures of one camera on their way to the disk: segments of a fixed number of pictures, made ahead, so
// that a full disk is known before it matters and adding a picture waits for nothing but the disk's own
// speed.
#include <cstdint>
#include <filesystem>
#include <future>
#include <optional>
#include <string>

#include "drivers/replay/frame_segment.hpp"

namespace shaker {

/// Used by one thread; it makes helpers of its own for what need not be waited for.
class FrameStore {
public:
    /// Pictures go to <folder>/<camera>-0000.h5 and so on; the folder is made when it is missing.
    /// segment_frames: pictures in a segment; 0: as many as make about 256 MB, at least 64. InputError when
    /// the folder has pictures of this camera already or the name cannot be a file's.
    FrameStore(std::filesystem::path folder, std::string camera, std::uint64_t segment_frames = 0);
    /// Leaves the files as they are: readable, not cut to what is in them.
    ~FrameStore();
    FrameStore(const FrameStore&) = delete;
    FrameStore& operator=(const FrameStore&) = delete;

    /// Makes the first segment; add() does it otherwise. Once. InputError when the size is not 1 to 65535
    /// pixels of 1 or 2 bytes; DeviceError, naming folder, bytes needed and bytes free, when there is no
    /// room.
    void prepare(const FrameShape& shape);
    /// Takes a picture, with prepare()'s size, and returns the number under which it is stored, from 1. It is
    /// safe from a crash of the program with the block of 8 it is in, or of up to 64 while `more` pictures
    /// are ready to follow: a writer that came behind catches up so. DeviceError when the disk is full or
    /// fails: once; from then on nothing is taken and the number is 0.
    std::uint64_t add(const Frame& frame, bool more = false);
    /// Returns when all pictures taken so far are on the disk. DeviceError as in add().
    void sync();
    /// sync(), and the end: the last segment cut to its pictures, the spare one gone, all of them linked in
    /// <folder>/<camera>.h5. After an error once more ends what was stored before it.
    void finish();
    /// Pictures that a crash of the program would not lose. After an error these are all there are.
    [[nodiscard]] std::uint64_t stored() const noexcept;
    /// False where pictures go through the page cache.
    [[nodiscard]] bool direct() const noexcept { return segment_ && segment_->direct(); }

private:
    void begin_spare();
    void go_on();
    template <class Work>
    auto guarded(Work work);

    std::filesystem::path folder_;
    std::string camera_;
    std::uint64_t segment_frames_;
    std::uint64_t taken_ = 0;
    bool closed_ = false;  // by an error or by finish(): takes nothing more
    std::optional<FrameSegment> segment_;
    std::future<FrameSegment> spare_;  // the one after segment_
    std::future<void> closing_;        // the one before, on its way to the disk
};

}  // namespace shaker
