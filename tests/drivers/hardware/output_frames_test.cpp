#include "drivers/hardware/alsa/output_frames.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace shaker::hardware {
namespace {

constexpr double steps = 8388608;  // a volt, of 24 bits at 1 V full scale

alsa::AlsaSettings settings_with(alsa::SecondChannel second) {
    alsa::AlsaSettings s;
    s.second_channel = second;
    s.dither = false;
    return s;
}

struct Heard {
    std::vector<double> drive, second;  // V
};
Heard decoded(std::span<const std::byte> bytes) {
    Heard heard;
    const auto volts = [&](std::size_t at) {
        std::uint32_t word = 0;
        for (std::size_t i = 0; i < 4; ++i) word |= std::to_integer<std::uint32_t>(bytes[at + i]) << (8 * i);
        return static_cast<std::int32_t>(word) / 256.0 / steps;
    };
    for (std::size_t at = 0; at < bytes.size(); at += 8) {
        heard.drive.push_back(volts(at));
        heard.second.push_back(volts(at + 4));
    }
    return heard;
}

std::vector<double> sine(std::size_t n, double turns_a_sample, double phase) {
    std::vector<double> volts(n);
    for (std::size_t i = 0; i < n; ++i)
        volts[i] = 0.6 * std::sin(2 * std::numbers::pi * (phase + turns_a_sample * static_cast<double>(i)));
    return volts;
}

// A drive of 20 Hz ends at any phase: the ramp reverses its slope within 1 ms and reduces its value to zero
// within 50 ms. Its steps are at most those of the drive or of a raised cosine from 0.6 V, and they change
// between samples by at most slope / (1 ms) or the cosine's curvature.
TEST(OutputFramesTest, RampContinuesValueAndSlopeAndEndsAtZero) {
    const alsa::AlsaSettings s = settings_with(alsa::SecondChannel::tone);
    const double steepest = 2 * std::numbers::pi * 0.6 * 20 / s.rate_hz;
    const double of_cosine = 0.5 * std::numbers::pi * 0.65 / s.ramp_frames();
    const double bend = (steepest + of_cosine) / (1e-3 * s.rate_hz) + 3 / steps;
    for (int eighth = 0; eighth < 8; ++eighth) {
        alsa::OutputFrames frames{s, alsa::PcmCodec{s.format, 0, 1}, 2, 240};
        const Heard heard =
            decoded(frames.block(sine(240, 20.0 / s.rate_hz, eighth / 8.0), std::vector<double>(240), {0}));
        ASSERT_EQ(heard.drive.size(), 240U + 2400U);
        double step_before = heard.drive[239] - heard.drive[238];
        for (std::size_t i = 240; i < heard.drive.size(); ++i) {
            const double step = heard.drive[i] - heard.drive[i - 1];
            ASSERT_LE(std::abs(step), steepest + of_cosine) << "eighth " << eighth << ", sample " << i;
            ASSERT_LE(std::abs(step - step_before), bend) << "eighth " << eighth << ", sample " << i;
            ASSERT_EQ(heard.second[i], 0);
            step_before = step;
        }
        EXPECT_EQ(heard.drive.back(), 0);
    }
}

TEST(OutputFramesTest, RampAfterRestartIgnoresOldSlope) {
    const alsa::AlsaSettings s = settings_with(alsa::SecondChannel::off);
    alsa::OutputFrames frames{s, alsa::PcmCodec{s.format, 0, 1}, 2, 240};
    const std::vector<double> still(240);
    frames.block(sine(240, 0.001, 0.1), still, {0});
    frames.restart();
    const Heard heard = decoded(frames.ramp());
    EXPECT_TRUE(std::all_of(heard.drive.begin(), heard.drive.end(), [](double v) { return v == 0; }));
}

TEST(OutputFramesTest, TriggerPulseContinuesInNextBlock) {
    alsa::AlsaSettings s = settings_with(alsa::SecondChannel::trigger);
    s.pulse_s = 10.0 / s.rate_hz;
    s.second_level = 0.5;
    alsa::OutputFrames frames{s, alsa::PcmCodec{s.format, 0, 1}, 2, 16};
    const std::vector<double> still(16);
    std::vector<double> trigger(16);
    trigger[12] = 1;
    const Heard first = decoded(frames.block(still, trigger, {0}));
    const Heard next = decoded(frames.block(still, still, {16}));
    EXPECT_EQ(first.second[11], 0);
    EXPECT_EQ(first.second[12], 0.5);
    EXPECT_EQ(first.second[15], 0.5);
    EXPECT_EQ(first.second[16], 0);  // the ramp
    EXPECT_EQ(next.second[5], 0.5);
    EXPECT_EQ(next.second[6], 0);
}

// At a quarter of the rate the tone's values are 0 and +-level.
TEST(OutputFramesTest, EnableToneEndsWithTheRamp) {
    alsa::AlsaSettings s = settings_with(alsa::SecondChannel::trigger);
    s.enable_channel = 4;
    s.enable_level = 0.25;
    s.enable_hz = 0.25 * s.rate_hz;
    alsa::OutputFrames frames{s, alsa::PcmCodec{s.format, 0, 1}, 4, 240};
    const auto tone = [](std::span<const std::byte> bytes) {
        const Heard pairs = decoded(bytes);  // channels 3 and 4 are every second pair
        std::vector<double> heard;
        for (std::size_t i = 1; i < pairs.second.size(); i += 2) {
            EXPECT_EQ(pairs.drive[i], 0) << "channel 3";
            heard.push_back(pairs.second[i]);
        }
        return heard;
    };
    const auto expect_tone = [](const std::vector<double>& heard, std::size_t length, std::size_t tick) {
        constexpr std::array quarter{0.0, 0.25, 0.0, -0.25};
        for (std::size_t i = 0; i < heard.size(); ++i)
            ASSERT_NEAR(heard[i], i < length ? quarter[(tick + i) % 4] : 0, 1e-6) << i;
    };
    const std::vector<double> volts(241, 0.5), still(241);
    const auto block = [&](std::size_t n, std::int64_t first, bool enabled) {
        return tone(frames.block(std::span{volts}.first(n), std::span{still}.first(n), {first}, enabled));
    };
    expect_tone(block(240, 0, false), 0, 0);
    expect_tone(block(239, 240, true), 239 + 2400, 240);
    frames.go_back(101);
    expect_tone(tone(frames.ramp(500)), 2400, 378);
    expect_tone(block(7, 378, true), 7 + 2400, 378);
    expect_tone(block(8, 385, false), 0, 385);
    block(8, 393, true);
    frames.restart();
    expect_tone(tone(frames.ramp()), 0, 0);
}

TEST(OutputFramesTest, FurtherChannelsAreSilent) {
    const alsa::AlsaSettings s = settings_with(alsa::SecondChannel::tone);
    alsa::OutputFrames frames{s, alsa::PcmCodec{s.format, 0, 1}, 4, 8};
    const auto bytes = frames.block(std::vector<double>(8, 0.5), std::vector<double>(8), {0});
    ASSERT_EQ(bytes.size(), (8U + 2400U) * 16U);
    for (std::size_t frame = 0; frame < 8; ++frame)
        for (std::size_t i = 8; i < 16; ++i) EXPECT_EQ(bytes[16 * frame + i], std::byte{0});
}

TEST(OutputFramesTest, EachSignalIsOnItsChannelAndTheOthersAreSilent) {
    alsa::AlsaSettings s = settings_with(alsa::SecondChannel::trigger);
    s.drive_channel = 3;
    s.trigger_channel = 1;
    s.enable_channel = 4;
    constexpr std::size_t channels = 5, n = 240;
    alsa::OutputFrames frames{s, alsa::PcmCodec{s.format, 0, 1}, channels, n};
    std::vector<double> pulses(n);
    pulses[7] = 1;
    const std::vector<double> drive = sine(n, 0.01, 0.1);
    const auto bytes = frames.block(drive, pulses, {0}, true);
    const auto volts = [&](std::size_t frame, std::size_t channel) {
        std::uint32_t word = 0;
        for (std::size_t i = 0; i < 4; ++i)
            word |= std::to_integer<std::uint32_t>(bytes[4 * (channels * frame + channel) + i]) << (8 * i);
        return static_cast<std::int32_t>(word) / 256.0 / steps;
    };
    double tone = 0;
    for (std::size_t i = 0; i < n; ++i) {
        EXPECT_NEAR(volts(i, 2), drive[i], 1 / steps);
        EXPECT_EQ(volts(i, 0) > 0.5, i >= 7 && i < 12) << i;
        EXPECT_EQ(volts(i, 1), 0);
        EXPECT_EQ(volts(i, 4), 0);
        tone = std::max(tone, std::abs(volts(i, 3)));
    }
    EXPECT_GT(tone, 0.9);
}

}  // namespace
}  // namespace shaker::hardware
