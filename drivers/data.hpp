#pragma once
// What crosses a device's edge, raw: counts and pixels with the index and the arrival they came with.
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "drivers/time.hpp"

namespace shaker {

/// What is wrong with a block or a frame. Bad data are marked, never thrown away.
enum class Quality : std::uint8_t { good = 0, gap = 1, clipped = 2, late = 4 };
constexpr Quality operator|(Quality a, Quality b) noexcept {
    return static_cast<Quality>(static_cast<unsigned>(a) | static_cast<unsigned>(b));
}
constexpr bool has(Quality set, Quality flag) noexcept {
    return (static_cast<unsigned>(set) & static_cast<unsigned>(flag)) != 0;
}

/// Tells when a sample of the drive is heard: what a DAC's clock is fitted to.
struct PlayTime {
    DacTick tick;    // of any sample near the block
    HostTime heard;  // when it leaves the converter
    /// Above 0 when the device ran empty: the block just given was not played, the output is at zero, and the
    /// next block begins this many samples after the end of that one. Ticks keep their place in time to a few
    /// samples; the clock's fit begins anew.
    std::int64_t lost = 0;
};

/// Consecutive accelerometer samples: sample i has tick first.n + i, one index instead of 64 stamps.
struct AccelBlock {
    static constexpr int capacity = 64;
    AccelTick first;
    HostTime arrived;     // of the last sample: the device's own stamp where it has host time, else when
                          // read() got it; only the clock map looks at it
    Quality quality{};    // gap: samples are missing before `first`
    int size = capacity;  // valid samples; less than `capacity` only before a gap and at the end
    std::array<std::array<std::int32_t, 3>, capacity> counts{};
};

/// A grey image: 8 or 16 bits a pixel in rows of `stride` bytes. Does not own its pixels.
struct ImageView {
    const std::byte* pixels = nullptr;
    int width = 0;
    int height = 0;
    std::ptrdiff_t stride = 0;  // bytes
    int bytes_per_pixel = 1;    // 1 or 2 (native endian)
    [[nodiscard]] const std::byte* row(int y) const noexcept { return pixels + y * stride; }
};

/// One exposure, immutable once it has left its camera.
struct Frame {
    CameraTick tick;
    HostTime arrived;
    std::optional<CameraStamp> stamp;        // start of the exposure on the camera's own clock
    std::optional<MasterTime> mid_exposure;  // known on the simulated rig, or told by a recorded session
    Quality quality{};
    int width = 0;
    int height = 0;
    int bytes_per_pixel = 1;
    std::vector<std::byte> pixels;  // rows without padding
    [[nodiscard]] ImageView view() const noexcept {
        return {pixels.data(), width, height, std::ptrdiff_t{width} * bytes_per_pixel, bytes_per_pixel};
    }
};
using FramePtr = std::shared_ptr<const Frame>;

}  // namespace shaker
