#include "daemon/frame_tail.hpp"

#include <sys/mman.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <new>

namespace shaker {

namespace {
constexpr double until_noticed_s = 0.2;  // from the sample that violates until the reduction hears of it
constexpr double after_s = 0.5;          // a run goes on for 0.3 s after a trip
constexpr std::size_t huge_page = std::size_t{2} << 20U;

std::size_t frames_in(double s, double rate_hz) {
    return static_cast<std::size_t>(std::max(1.0, std::ceil(s * rate_hz - 1e-6)));
}
}  // namespace

FrameTail::FrameTail(double rate_hz)
    : most_before_{frames_in(tail_s + until_noticed_s, rate_hz)},
      slots_(most_before_ + frames_in(after_s, rate_hz)) {}

// The first touch of ordinary pages would take longer than the copy, by far.
void FrameTail::begin(std::size_t frame_bytes) {
    const std::size_t bytes = (capacity() * frame_bytes + huge_page - 1) / huge_page * huge_page;
    pixels_.reset(static_cast<std::byte*>(std::aligned_alloc(huge_page, bytes)));
    if (!pixels_) throw std::bad_alloc{};
    madvise(pixels_.get(), bytes, MADV_HUGEPAGE);  // refused: it works all the same
    frame_bytes_ = frame_bytes;
    bytes_ = bytes;
}

void FrameTail::put(std::size_t slot, const Frame& frame) {
    Frame& to = slots_[slot];
    to.tick = frame.tick;
    to.arrived = frame.arrived;
    to.stamp = frame.stamp;
    to.mid_exposure = frame.mid_exposure;
    to.quality = frame.quality;
    to.width = frame.width;
    to.height = frame.height;
    to.bytes_per_pixel = frame.bytes_per_pixel;
    std::memcpy(pixels_.get() + slot * frame_bytes_, frame.pixels.data(), frame_bytes_);
}

void FrameTail::push(const Frame& frame) {
    if (!pixels_ && !frame.pixels.empty()) begin(frame.pixels.size());
    if (frame.pixels.size() != frame_bytes_ || (held_ && most_before_ + after_ == capacity())) {
        ++lost_;
        return;
    }
    if (held_) {
        put(most_before_ + after_++, frame);
        return;
    }
    put((oldest_ + before_) % most_before_, frame);
    if (before_ < most_before_) {
        ++before_;
        return;
    }
    oldest_ = (oldest_ + 1) % most_before_;
    whole_ = false;
}

Frame FrameTail::operator[](std::size_t i) const {
    const std::size_t slot = i < before_ ? (oldest_ + i) % most_before_ : most_before_ + i - before_;
    Frame frame = slots_[slot];
    const std::byte* pixels = pixels_.get() + slot * frame_bytes_;
    frame.pixels.assign(pixels, pixels + frame_bytes_);
    return frame;
}

}  // namespace shaker
