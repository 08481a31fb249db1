#include "drivers/hardware/alsa/output_frames.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

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

constexpr double slope_lasts_s = 1e-3;

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

OutputFrames::OutputFrames(const AlsaSettings& settings, const PcmCodec& codec, std::size_t channels,
                           std::size_t most_frames)
    : codec_{codec},
      channels_{channels},
      kind_{settings.second_channel},
      dither_{settings.dither},
      level_V_{settings.second_level * settings.full_scale_V},
      pulse_samples_{std::max(1L, std::lround(settings.pulse_s * settings.rate_hz))},
      tone_{turns_per_sample(settings.tone_hz, settings.rate_hz)},
      drive_at_{static_cast<std::size_t>(settings.drive_channel) - 1},
      second_at_{static_cast<std::size_t>(settings.trigger_channel) - 1},
      enable_at_{static_cast<std::size_t>(std::max(1, settings.enable_channel)) - 1},
      enable_{settings.enable_channel > 0},
      enable_level_V_{settings.enable_level * settings.full_scale_V},
      enable_tone_{turns_per_sample(settings.enable_hz, settings.rate_hz)},
      decay_{std::exp(-1 / (slope_lasts_s * settings.rate_hz))},
      ends_(static_cast<std::size_t>(settings.buffer_frames)),
      ramp_(static_cast<std::size_t>(settings.ramp_frames())),
      bytes_(std::max(most_frames + ramp_.size(), ends_.size()) * frame_bytes()) {
    const auto length = static_cast<double>(ramp_.size());
    for (std::size_t k = 0; k < ramp_.size(); ++k)
        ramp_[k] = 0.5 + 0.5 * std::cos(std::numbers::pi * static_cast<double>(k + 1) / length);
}

std::span<const std::byte> OutputFrames::block(std::span<const double> volts, std::span<const double> trigger,
                                               DacTick first, bool enabled) noexcept {
    end_.enabled = enabled && enable_;
    for (std::size_t i = 0; i < volts.size(); ++i) {
        const DacTick tick{first.n + static_cast<std::int64_t>(i)};
        put(i, dither_ ? codec_.dithered(volts[i], tick, 0) : codec_.code(volts[i]), second(trigger[i], tick),
            end_.enabled ? enable_tone(tick) : 0);
        end_.slope = volts[i] - end_.volts;
        end_.volts = volts[i];
        ends_[next_] = end_;
        next_ = (next_ + 1) % ends_.size();
        known_ = std::min(known_ + 1, ends_.size());
    }
    tick_ = {first.n + static_cast<std::int64_t>(volts.size())};
    put_ramp(volts.size());
    return std::span{bytes_}.first((volts.size() + ramp_.size()) * frame_bytes());
}

std::span<const std::byte> OutputFrames::ramp(std::int64_t silence) noexcept {
    const std::size_t frames = ramp_.size() + static_cast<std::size_t>(silence);
    put_ramp(0);
    for (std::size_t k = ramp_.size(); k < frames; ++k) put(k, 0, 0, 0);
    return std::span{bytes_}.first(frames * frame_bytes());
}

std::int64_t OutputFrames::most_back() const noexcept {
    return std::max<std::int64_t>(0, static_cast<std::int64_t>(known_) - 1);
}

void OutputFrames::go_back(std::int64_t samples) noexcept {
    const auto n = static_cast<std::size_t>(samples);
    known_ -= n;
    tick_.n -= samples;
    next_ = (next_ + ends_.size() - n) % ends_.size();
    end_ = ends_[(next_ + ends_.size() - 1) % ends_.size()];
}

void OutputFrames::restart() noexcept {
    end_ = {};
    known_ = 0;
}

void OutputFrames::put_ramp(std::size_t at) noexcept {
    double carried = 0, step = end_.slope;
    for (std::size_t k = 0; k < ramp_.size(); ++k) {
        carried += step;
        step *= decay_;
        const DacTick tick{tick_.n + static_cast<std::int64_t>(k)};
        put(at + k, codec_.code(ramp_[k] * (end_.volts + carried)), 0, end_.enabled ? enable_tone(tick) : 0);
    }
}

std::int32_t OutputFrames::second(double trigger, DacTick tick) noexcept {
    switch (kind_) {
        case SecondChannel::trigger:
            if (trigger > 0.5) end_.pulse_left = pulse_samples_;
            return end_.pulse_left > 0 ? (--end_.pulse_left, codec_.code(level_V_)) : 0;
        case SecondChannel::tone:
            return tone(tone_, level_V_, tick, 1);
        case SecondChannel::off:
            break;
    }
    return 0;
}

std::int32_t OutputFrames::tone(Turns step, double level_V, DacTick tick, unsigned channel) noexcept {
    const Turns phase = step * static_cast<Turns>(tick.n);
    const double volts =
        level_V * std::sin(2 * std::numbers::pi * std::ldexp(static_cast<double>(high_word(phase)), -64));
    return dither_ ? codec_.dithered(volts, tick, channel) : codec_.code(volts);
}

std::int32_t OutputFrames::enable_tone(DacTick tick) noexcept {
    constexpr unsigned dither_channel = 2;
    return tone(enable_tone_, enable_level_V_, tick, dither_channel);
}

void OutputFrames::put(std::size_t frame, std::int32_t drive, std::int32_t second,
                       std::int32_t enable) noexcept {
    std::byte* at = bytes_.data() + frame * frame_bytes();
    codec_.put(at + drive_at_ * codec_.bytes(), drive);
    if (kind_ != SecondChannel::off) codec_.put(at + second_at_ * codec_.bytes(), second);
    if (enable_) codec_.put(at + enable_at_ * codec_.bytes(), enable);
}

}  // namespace shaker::alsa
