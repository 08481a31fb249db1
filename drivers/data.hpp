#pragma once
// Raw data as devices deliver them: counts and pixels with sample index and arrival time.
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "drivers/time.hpp"

namespace shaker {

/// Defects of a block or a frame, as flags. Bad data are marked, never discarded.
enum class Quality : std::uint8_t { good = 0, gap = 1, clipped = 2, late = 4 };
constexpr Quality operator|(Quality a, Quality b) noexcept {
    return static_cast<Quality>(static_cast<unsigned>(a) | static_cast<unsigned>(b));
}
constexpr bool has(Quality set, Quality flag) noexcept {
    return (static_cast<unsigned>(set) & static_cast<unsigned>(flag)) != 0;
}

/// The moment a sample of the drive leaves the converter. The DAC's clock is fitted to these.
struct PlayTime {
    DacTick tick;    // of any sample in or near the block
    HostTime heard;  // host time at which `tick` leaves the converter
    /// Samples, >= 0. Above 0 after an underrun: the block just written was not played, the output is
    /// at zero, and the next block begins `lost` samples after the end of that block. Ticks keep
    /// their place in time to a few samples; the fit of the clock restarts.
    std::int64_t lost = 0;
    /// Samples, >= 0. Above 0 after a stall of the converter: that many samples before the end of the block
    /// just written were queued and not played, or played late. Not recorded.
    std::int64_t unheard = 0;
};

/// Consecutive accelerometer samples. Sample i has tick first.n + i.
struct AccelBlock {
    static constexpr int capacity = 64;
    AccelTick first;
    HostTime arrived;     // of the last sample: the device's own stamp if it stamps in host time, else the
                          // return of read(). Used only to fit the clock
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

/// Place of one target in an exposure, px; pixel centres are at whole numbers. NaN: the target is not seen.
struct Sighting {
    double x_px = std::numeric_limits<double>::quiet_NaN();
    double y_px = std::numeric_limits<double>::quiet_NaN();
    double sd_px = std::numeric_limits<double>::quiet_NaN();  // standard deviation along the shaker's axis
};

/// One exposure, immutable once it has left its camera. It carries pixels or, from a camera with
/// View::positions, sightings.
struct Frame {
    CameraTick tick;
    HostTime arrived;
    std::optional<CameraStamp> stamp;  // start of the exposure on the camera's own clock
    /// Known on the simulated rig and in recorded sessions; else empty.
    std::optional<MasterTime> mid_exposure;
    Quality quality{};
    int width = 0;
    int height = 0;
    int bytes_per_pixel = 1;
    std::vector<std::byte> pixels;      // rows without padding
    std::vector<Sighting> sightings{};  // one for each target of the view, in its order
    [[nodiscard]] ImageView view() const noexcept {
        return {pixels.data(), width, height, std::ptrdiff_t{width} * bytes_per_pixel, bytes_per_pixel};
    }
};
using FramePtr = std::shared_ptr<const Frame>;

}  // namespace shaker
