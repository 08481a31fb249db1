#pragma once
// The binary messages of a live stream: a header of 40 bytes, then 32-bit floats, all little-endian.
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "daemon/bench_state.hpp"
#include "daemon/live_feed.hpp"

namespace shaker::web {

enum class StreamId : std::uint16_t {
    acceleration = 1,
    waveform = 2,
    cycle = 3,
    track = 4,
    first_camera = 16
};
inline constexpr std::uint32_t frame_magic = 0x534B4431;

/// Even samples of some channels; a channel's values stand behind one another.
struct Samples {
    StreamId id{};
    std::uint64_t first = 0;
    double t0_s = 0, dt_s = 0;
    std::vector<std::vector<float>> channels;
    bool gap = false, pairs = false, decimated = false;
};
std::string frame_of(const Samples& samples);

/// As many samples as fit `width` pixels: least and largest of each pixel's, in the order in which they came,
/// so that no peak is hidden. Fewer than 2 width stay as they are.
Samples decimated(const LiveSeries::Part& part, std::size_t channels, std::size_t width, StreamId id);
/// Two periods: asked, measured.
Samples waveform_of(const WaveformState& waveform);
/// The walker's averaged period: x, its error, v, its error, v of the base.
Samples cycle_of(const Reduction& reduction);
/// Camera number k's picture as JPEG with its marks; empty when it cannot be encoded.
std::string picture_frame(const PictureState& picture, std::size_t k);

}  // namespace shaker::web
