#pragma once
// Binary messages of a live stream: a header of 40 bytes, then 32-bit floats, all little-endian.
#include <cstdint>
#include <string>
#include <vector>

#include "daemon/service/bench_port.hpp"
#include "daemon/service/bench_state.hpp"

namespace shaker::web {

enum class StreamId : std::uint16_t {
    acceleration = 1,
    waveform = 2,
    cycle = 3,
    track = 4,
    first_camera = 16
};
inline constexpr std::uint32_t frame_magic = 0x534B4431;

/// Evenly spaced samples of several channels; the values of one channel are contiguous.
struct Samples {
    StreamId id{};
    std::uint64_t first = 0;
    double t0_s = 0, dt_s = 0;
    std::vector<std::vector<float>> channels;
    bool gap = false, pairs = false, decimated = false;
};
std::string frame_of(const Samples& samples);

/// Reduces samples to `width` pixels: smallest and largest value of each pixel, in order of time, so that no
/// peak is hidden. Fewer than 2 width samples are unchanged.
Samples decimated(const service::LiveSeries::Part& part, std::size_t channels, std::size_t width,
                  StreamId id);
/// Two periods: requested and measured.
Samples waveform_of(const service::WaveformState& waveform);
/// The walker's averaged period: x, its error, v, its error, v of the base.
Samples cycle_of(const reduction::Reduction& reduction);
/// Loads the encoder of pictures, which the first picture would load otherwise. Throws DeviceError.
void load_encoder();
/// Picture of camera k as JPEG with its marks; empty when encoding fails.
std::string picture_frame(const service::PictureState& picture, std::size_t k);

}  // namespace shaker::web
