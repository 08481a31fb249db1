#include "daemon/frame_tail.hpp"

#include <algorithm>
#include <cmath>

namespace shaker {

namespace {
constexpr double until_noticed_s = 0.2;  // from the sample that violates until the reduction hears of it
constexpr double after_s = 0.5;          // a run goes on for 0.3 s after a trip
std::size_t frames_in(double s, double rate_hz) {
    return static_cast<std::size_t>(std::max(1.0, std::ceil(s * rate_hz - 1e-6)));
}
}  // namespace

FrameTail::FrameTail(double rate_hz)
    : most_before_{frames_in(tail_s + until_noticed_s, rate_hz)}, most_after_{frames_in(after_s, rate_hz)} {
    slots_.resize(capacity());
}

void FrameTail::push(const Frame& frame) {
    if (held_) {
        if (after_ < most_after_)
            slots_[most_before_ + after_++] = frame;
        else
            ++lost_;
        return;
    }
    slots_[(oldest_ + before_) % most_before_] = frame;
    if (before_ < most_before_) {
        ++before_;
        return;
    }
    oldest_ = (oldest_ + 1) % most_before_;
    whole_ = false;
}

const Frame& FrameTail::operator[](std::size_t i) const noexcept {
    return i < before_ ? slots_[(oldest_ + i) % most_before_] : slots_[most_before_ + i - before_];
}

std::size_t FrameTail::bytes() const noexcept {
    std::size_t sum = 0;
    for (const Frame& f : slots_) sum += f.pixels.capacity();
    return sum;
}

}  // namespace shaker
