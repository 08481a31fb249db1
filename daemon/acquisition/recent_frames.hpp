#pragma once
// Copies of a camera's newest frames in bounded memory: what a trip's recording shows of the time before it.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <vector>

#include "drivers/data.hpp"

namespace shaker::acquisition {

/// Seconds of every stream that a trip's recording holds before the sample that violated.
inline constexpr double tail_s = 2;

/// The frames of tail_s and a little more; after hold() all that comes until the run ends, bounded too.
/// Frames are copied, because a camera's pool is smaller than this. One thread.
class RecentFrames {
public:
    /// rate_hz: exposures a second; one that delivers more of them is kept for less time.
    explicit RecentFrames(double rate_hz);
    /// Copies a frame; the oldest gives way to it. Counted instead: one that finds no room after hold(), and
    /// one of another size than the first. Throws std::bad_alloc when there is no memory for it.
    void push(const Frame& frame);
    /// The drive was stopped: what led to it stays.
    void hold() noexcept { held_ = true; }
    /// The run goes on all the same: the tail begins anew.
    void release() noexcept {
        oldest_ = before_ = after_ = 0;
        held_ = whole_ = false;
    }

    [[nodiscard]] std::size_t size() const noexcept { return before_ + after_; }
    /// No frame has been left out so far.
    [[nodiscard]] bool whole() const noexcept { return whole_; }
    /// A copy; 0 is the oldest.
    [[nodiscard]] Frame operator[](std::size_t i) const;
    /// The most frames there ever are: 2.7 s x rate.
    [[nodiscard]] std::size_t capacity() const noexcept { return slots_.size(); }
    /// Memory for pixels, taken in pieces of up to 16 MiB as it is needed: at most capacity() x width x
    /// height x bytes_per_pixel and, because pieces hold whole frames, a sixteenth more (frames up to 1 MiB)
    /// and the rest of a piece.
    [[nodiscard]] std::size_t bytes() const noexcept;
    [[nodiscard]] std::uint64_t lost() const noexcept { return lost_; }

private:
    struct Free {
        void operator()(std::byte* p) const noexcept { std::free(p); }
    };
    void begin(std::size_t frame_bytes);
    [[nodiscard]] std::byte* pixels_of(std::size_t slot) const noexcept;
    void put(std::size_t slot, const Frame& frame);

    std::size_t most_before_;
    std::vector<Frame> slots_;  // without pixels: a ring of most_before_, then those after hold()
    std::vector<std::unique_ptr<std::byte, Free>> pieces_;
    std::size_t frame_bytes_ = 0;
    std::size_t piece_bytes_ = 0, piece_frames_ = 1;
    std::size_t oldest_ = 0, before_ = 0, after_ = 0;
    bool held_ = false, whole_ = true;
    std::uint64_t lost_ = 0;
};

}  // namespace shaker::acquisition
