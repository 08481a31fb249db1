#include "drivers/hardware/alsa/output_frames.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace shaker::alsa {

namespace {
constexpr double slope_lasts_s = 1e-3;
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
      enable_{settings.enable_channel > 0 ? static_cast<std::size_t>(settings.enable_channel) - 1 : 0},
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
    end_.enabled = enabled && enable_ > 0;
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
    codec_.put(at, drive);
    codec_.put(at + codec_.bytes(), second);
    if (enable_ > 0) codec_.put(at + enable_ * codec_.bytes(), enable);
}

}  // namespace shaker::alsa
