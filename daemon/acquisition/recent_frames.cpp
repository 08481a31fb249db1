#include "daemon/acquisition/recent_frames.hpp"

#include <sys/mman.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <new>

namespace shaker::acquisition {

namespace {
constexpr double until_noticed_s = 0.2;  // from the sample that violates a limit until the reduction knows
constexpr double after_s = 0.5;          // after a trip; the run continues for 0.3 s
constexpr std::size_t huge_page = std::size_t{2} << 20U;
constexpr std::size_t most_piece = 8 * huge_page;  // allocated in a few ms

std::size_t frames_in(double s, double rate_hz) {
    return static_cast<std::size_t>(std::max(1.0, std::ceil(s * rate_hz - 1e-6)));
}
}  // namespace

RecentFrames::RecentFrames(double rate_hz)
    : most_before_{frames_in(tail_s + until_noticed_s, rate_hz)},
      slots_(most_before_ + frames_in(after_s, rate_hz)) {}

void RecentFrames::begin(std::size_t frame_bytes) {
    frame_bytes_ = frame_bytes;
    const std::size_t all = capacity() * frame_bytes;
    const std::size_t wanted = std::max(frame_bytes, std::min(all, most_piece));
    piece_bytes_ = (wanted + huge_page - 1) / huge_page * huge_page;
    piece_frames_ = piece_bytes_ / frame_bytes;
    pieces_.resize((capacity() + piece_frames_ - 1) / piece_frames_);
}

std::size_t RecentFrames::bytes() const noexcept {
    const auto taken = std::ranges::count_if(pieces_, [](const auto& p) { return p != nullptr; });
    return static_cast<std::size_t>(taken) * piece_bytes_;
}

std::byte* RecentFrames::pixels_of(std::size_t slot) const noexcept {
    return pieces_[slot / piece_frames_].get() + slot % piece_frames_ * frame_bytes_;
}

void RecentFrames::put(std::size_t slot, const Frame& frame) {
    Frame& to = slots_[slot];
    to.tick = frame.tick;
    to.arrived = frame.arrived;
    to.stamp = frame.stamp;
    to.mid_exposure = frame.mid_exposure;
    to.quality = frame.quality;
    to.width = frame.width;
    to.height = frame.height;
    to.bytes_per_pixel = frame.bytes_per_pixel;
    to.sightings = frame.sightings;
    if (frame_bytes_ == 0) return;
    auto& piece = pieces_[slot / piece_frames_];
    if (!piece) {
        piece.reset(static_cast<std::byte*>(std::aligned_alloc(huge_page, piece_bytes_)));
        if (!piece) throw std::bad_alloc{};
        // The first access to ordinary pages takes longer than the copy. A refusal does no harm.
        madvise(piece.get(), piece_bytes_, MADV_HUGEPAGE);
    }
    std::memcpy(pixels_of(slot), frame.pixels.data(), frame_bytes_);
}

void RecentFrames::push(const Frame& frame) {
    if (frame_bytes_ == 0 && !frame.pixels.empty()) begin(frame.pixels.size());
    const bool empty = frame.pixels.empty() && frame.sightings.empty();
    if (empty || frame.pixels.size() != frame_bytes_ || (held_ && most_before_ + after_ == capacity())) {
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

Frame RecentFrames::operator[](std::size_t i) const {
    const std::size_t slot = i < before_ ? (oldest_ + i) % most_before_ : most_before_ + i - before_;
    Frame frame = slots_[slot];
    if (frame_bytes_ == 0) return frame;
    const std::byte* pixels = pixels_of(slot);
    frame.pixels.assign(pixels, pixels + frame_bytes_);
    return frame;
}

}  // namespace shaker::acquisition
