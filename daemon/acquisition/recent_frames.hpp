#pragma once
// Copies of a camera's newest frames in bounded memory, for the recording of a trip.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <vector>

#include "drivers/data.hpp"

namespace shaker::acquisition {

/// Duration of all streams in the recording of a trip before the sample that violated the limit, s.
inline constexpr double tail_s = 2;

/// The frames of slightly more than tail_s. After hold() also all frames until the end of the run, bounded
/// too. Frames are copied, because a camera's pool is smaller. One thread.
class RecentFrames {
public:
    /// rate_hz: exposures per second. At a higher real rate the frames cover less time.
    explicit RecentFrames(double rate_hz);
    /// Copies a frame and removes the oldest one. A frame that finds no room after hold() and a frame that
    /// differs in size from the first are counted as lost. Throws std::bad_alloc without memory.
    void push(const Frame& frame);
    /// Call it at a trip: the frames before it are kept.
    void hold() noexcept { held_ = true; }
    /// Call it when the run continues after a trip: removes all frames and forgets their losses.
    void release() noexcept {
        oldest_ = before_ = after_ = 0;
        lost_ = 0;
        held_ = whole_ = false;
    }

    [[nodiscard]] std::size_t size() const noexcept { return before_ + after_; }
    /// True while no frame has been removed or lost.
    [[nodiscard]] bool whole() const noexcept { return whole_; }
    /// Frame i; 0 is the oldest.
    [[nodiscard]] Frame operator[](std::size_t i) const;
    /// Largest number of frames: 2.7 s x rate.
    [[nodiscard]] std::size_t capacity() const noexcept { return slots_.size(); }
    /// Allocated memory for pixels, bytes. It grows in pieces of up to 16 MiB to at most capacity() x width x
    /// height x bytes_per_pixel, plus 1/16 (frames up to 1 MiB) and the rest of a piece, because pieces hold
    /// whole frames.
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
    std::vector<Frame> slots_;  // without pixels: a ring of most_before_, then the frames after hold()
    std::vector<std::unique_ptr<std::byte, Free>> pieces_;
    std::size_t frame_bytes_ = 0;
    std::size_t piece_bytes_ = 0, piece_frames_ = 1;
    std::size_t oldest_ = 0, before_ = 0, after_ = 0;
    bool held_ = false, whole_ = true;
    std::uint64_t lost_ = 0;
};

}  // namespace shaker::acquisition
