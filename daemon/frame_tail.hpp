#pragma once
// Copies of a camera's newest frames in bounded memory: what a trip's recording shows of the time before it.
#include <cstddef>
#include <cstdint>
#include <vector>

#include "drivers/data.hpp"

namespace shaker {

/// Seconds of every stream that a trip's recording holds before the sample that violated.
inline constexpr double tail_s = 2;

/// The frames of tail_s and a little more; after hold() all that comes until the run ends, bounded too.
/// Frames are copied, because a camera's pool is smaller than this. One thread.
class FrameTail {
public:
    /// rate_hz: exposures a second; one that delivers more of them is kept for less time.
    explicit FrameTail(double rate_hz);
    /// Copies a frame; the oldest gives way to it. After hold() a frame that finds no room is counted
    /// instead.
    void push(const Frame& frame);
    /// The drive was stopped: what led to it stays.
    void hold() noexcept { held_ = true; }

    [[nodiscard]] std::size_t size() const noexcept { return before_ + after_; }
    /// No frame has been left out so far.
    [[nodiscard]] bool whole() const noexcept { return whole_; }
    /// From the oldest on.
    [[nodiscard]] const Frame& operator[](std::size_t i) const noexcept;
    /// The most frames there ever are; as many of width x height x bytes_per_pixel bytes is what it takes of
    /// memory: 2.7 s x rate x size.
    [[nodiscard]] std::size_t capacity() const noexcept { return most_before_ + most_after_; }
    /// Of pixels, as they are held now.
    [[nodiscard]] std::size_t bytes() const noexcept;
    /// Frames without room after hold().
    [[nodiscard]] std::uint64_t lost() const noexcept { return lost_; }

private:
    std::size_t most_before_, most_after_;
    std::vector<Frame> slots_;  // a ring of most_before_, then those after hold()
    std::size_t oldest_ = 0, before_ = 0, after_ = 0;
    bool held_ = false, whole_ = true;
    std::uint64_t lost_ = 0;
};

}  // namespace shaker
