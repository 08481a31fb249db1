#include "drivers/hardware/alsa/output_frames.hpp"

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
      decay_{std::exp(-1 / (slope_lasts_s * settings.rate_hz))},
      ramp_(static_cast<std::size_t>(settings.ramp_frames())),
      bytes_((most_frames + ramp_.size()) * frame_bytes()) {
    const auto length = static_cast<double>(ramp_.size());
    for (std::size_t k = 0; k < ramp_.size(); ++k)
        ramp_[k] = 0.5 + 0.5 * std::cos(std::numbers::pi * static_cast<double>(k + 1) / length);
}

std::span<const std::byte> OutputFrames::block(std::span<const double> volts, std::span<const double> trigger,
                                               DacTick first) noexcept {
    for (std::size_t i = 0; i < volts.size(); ++i) {
        const DacTick tick{first.n + static_cast<std::int64_t>(i)};
        put(i, dither_ ? codec_.dithered(volts[i], tick, 0) : codec_.code(volts[i]),
            second(trigger[i], tick));
        slope_V_ = volts[i] - last_V_;
        last_V_ = volts[i];
    }
    put_ramp(volts.size());
    return std::span{bytes_}.first((volts.size() + ramp_.size()) * frame_bytes());
}

std::span<const std::byte> OutputFrames::ramp() noexcept {
    put_ramp(0);
    return std::span{bytes_}.first(ramp_.size() * frame_bytes());
}

void OutputFrames::restart() noexcept {
    last_V_ = slope_V_ = 0;
    pulse_left_ = 0;
}

void OutputFrames::put_ramp(std::size_t at) noexcept {
    double carried = 0, step = slope_V_;
    for (std::size_t k = 0; k < ramp_.size(); ++k) {
        carried += step;
        step *= decay_;
        put(at + k, codec_.code(ramp_[k] * (last_V_ + carried)), 0);
    }
}

std::int32_t OutputFrames::second(double trigger, DacTick tick) noexcept {
    switch (kind_) {
        case SecondChannel::trigger:
            if (trigger > 0.5) pulse_left_ = pulse_samples_;
            return pulse_left_ > 0 ? (--pulse_left_, codec_.code(level_V_)) : 0;
        case SecondChannel::tone: {
            const Turns phase = tone_ * static_cast<Turns>(tick.n);
            const double volts = level_V_ * std::sin(2 * std::numbers::pi *
                                                     std::ldexp(static_cast<double>(high_word(phase)), -64));
            return dither_ ? codec_.dithered(volts, tick, 1) : codec_.code(volts);
        }
        case SecondChannel::off:
            break;
    }
    return 0;
}

void OutputFrames::put(std::size_t frame, std::int32_t drive, std::int32_t second) noexcept {
    std::byte* at = bytes_.data() + frame * frame_bytes();
    codec_.put(at, drive);
    codec_.put(at + codec_.bytes(), second);
}

}  // namespace shaker::alsa
