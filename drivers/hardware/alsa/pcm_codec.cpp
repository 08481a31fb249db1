#include "drivers/hardware/alsa/pcm_codec.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace shaker::alsa {

namespace {

struct Container {
    std::size_t bytes;
    int bits;  // valid bits of a sample
};
constexpr int most_bits = 24;
constexpr std::array<Container, 4> containers{{{4, 32}, {4, 24}, {3, 24}, {2, 16}}};

// A bijection of 64 bits in which every input bit changes half of the output bits: the finaliser of the
// splitmix64 generator (Steele, Lea, Flood 2014).
constexpr std::uint64_t mixed(std::uint64_t x) noexcept {
    x += 0x9e3779b97f4a7c15;
    x = (x ^ (x >> 30U)) * 0xbf58476d1ce4e5b9;
    x = (x ^ (x >> 27U)) * 0x94d049bb133111eb;
    return x ^ (x >> 31U);
}

}  // namespace

PcmCodec::PcmCodec(SampleFormat format, int significant_bits, double full_scale_V) noexcept {
    const Container& c = containers[static_cast<std::size_t>(format)];
    bits_ = std::min(most_bits, c.bits);
    if (significant_bits > 0) bits_ = std::min(bits_, significant_bits);
    bytes_ = c.bytes;
    shift_ = c.bits - bits_;
    const double full_scale = std::ldexp(1.0, bits_ - 1);
    steps_per_volt_ = full_scale / full_scale_V;
    most_ = full_scale - 1;
}

std::int32_t PcmCodec::rounded(double volts, double noise) const noexcept {
    const double steps = volts * steps_per_volt_ + noise;
    if (std::isnan(steps)) return 0;
    return static_cast<std::int32_t>(std::lrint(std::clamp(steps, -most_, most_)));
}

std::int32_t PcmCodec::dithered(double volts, DacTick tick, unsigned channel) const noexcept {
    constexpr double unit = 1.0 / 4294967296.0;
    const std::uint64_t random = mixed(2 * static_cast<std::uint64_t>(tick.n) + channel);
    const auto high = static_cast<double>(random >> 32U), low = static_cast<double>(random & 0xffffffffU);
    return rounded(volts, unit * (high + low) - 1);
}

void PcmCodec::put(std::byte* at, std::int32_t code) const noexcept {
    const auto word = static_cast<std::uint32_t>(code) << static_cast<unsigned>(shift_);
    for (std::size_t i = 0; i < bytes_; ++i) at[i] = static_cast<std::byte>(word >> (8 * i));
}

}  // namespace shaker::alsa
