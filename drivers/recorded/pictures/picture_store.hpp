#pragma once
// PictureStore: writes the pictures of one camera in segments of a fixed number of pictures. Segments are
// allocated ahead: a full disk is noticed early, and adding a picture waits only for the disk's speed.
#include <cstdint>
#include <filesystem>
#include <functional>
#include <future>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "drivers/beside.hpp"
#include "drivers/recorded/h5/file_lock.hpp"
#include "drivers/recorded/pictures/segment.hpp"

namespace shaker::pictures {

/// Usual size of a segment, bytes. A store keeps two of them ready while pictures arrive.
inline constexpr std::uint64_t usual_segment_bytes = 256'000'000;

/// Used by one thread; creates helper threads for work that need not be waited for.
class PictureStore {
public:
    /// Pictures go to <folder>/<camera>-0000.h5 and so on; the folder is created when missing.
    /// segment_frames: pictures per segment; 0: about 256 MB, at least 64. InputError when the folder already
    /// has pictures of this camera or the name cannot be a file name.
    PictureStore(std::filesystem::path folder, std::string camera, std::uint64_t segment_frames = 0);
    /// Keeps the files: readable, but not cut to their contents.
    ~PictureStore();
    PictureStore(const PictureStore&) = delete;
    PictureStore& operator=(const PictureStore&) = delete;

    /// Creates the first segment, which add() would otherwise do. Call once. From then on the folder is
    /// locked for the life of this object, together with other stores. InputError when the size is not 1 to
    /// 65535 pixels of 1 or 2 bytes, or the folder is a link; DeviceError with folder, bytes required and
    /// bytes free when there is no space.
    void prepare(const PictureShape& shape);
    /// Stores a picture of prepare()'s size and returns its number, from 1. A crash of the program cannot
    /// lose it once its block of 8 is written; while `more` pictures are ready to follow, blocks grow up to
    /// 64, so that a delayed writer catches up. DeviceError, once, when the disk is full or fails; after that
    /// nothing is stored and the number is 0.
    std::uint64_t add(const Frame& frame, bool more = false);
    /// Returns when all pictures stored so far are on the disk. DeviceError as in add().
    void sync();
    /// sync(), then ends the recording: cuts the last segment to its pictures (one that is nearly full keeps
    /// its length, and the disk gets the space), removes the spare one and links all in <folder>/<camera>.h5.
    /// After an error, a second call ends the pictures stored before it.
    void finish();
    /// finish() in a thread of the store.
    std::future<void> finish_beside();
    /// Number of pictures that a crash of the program would not lose. After an error there are no others.
    [[nodiscard]] std::uint64_t stored() const noexcept;
    /// False if pictures go through the page cache.
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
    h5::FileLock lock_;    // of the folder: nobody else removes pictures
    bool closed_ = false;  // by an error or by finish(): nothing more is stored
    std::optional<PictureSegment> segment_;
    std::future<PictureSegment> spare_;          // the next one
    std::future<void> closing_;                  // the previous one, being synchronised to the disk
    Beside maker_{"", true}, closer_{"", true};  // the last members: they end first
};

/// Calls finish() of all stores at the same time, since each may copy a segment. progress: called after each.
void finish(std::span<const std::unique_ptr<PictureStore>> stores, const std::function<void()>& progress);

}  // namespace shaker::pictures
