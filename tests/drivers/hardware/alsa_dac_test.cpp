#include "drivers/hardware/alsa/alsa_dac.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "calibration/clocks/clock_tracker.hpp"
#include "drivers/hardware/alsa/output_frames.hpp"
#include "tests/support/devices/mock_dac.hpp"
#include "tests/support/in_real_time.hpp"
#include "tests/support/no_alloc.hpp"
#include "tests/support/remote/player.hpp"

namespace shaker::hardware {
namespace {

using test::MockDac;
using test::Player;
using test::test_block;
using test::test_drive;
constexpr std::size_t block = Player::block;

class AlsaFormatTest : public testing::TestWithParam<alsa::SampleFormat> {};

TEST_P(AlsaFormatTest, PlaysEverySampleExactly) {
    MockDac mock;
    mock.settings.format = GetParam();
    mock.settings.second_channel = alsa::SecondChannel::tone;
    constexpr std::size_t blocks = 60;
    {
        alsa::AlsaDac dac{mock.settings};
        Player player{dac};
        player.play(blocks);
        if (!test::in_real_time) return;
        EXPECT_EQ(dac.counts().taken, blocks * block);
        EXPECT_EQ(dac.counts().incidents, 0U);
    }
    mock.listen();
    ASSERT_EQ(mock.converter.stream_starts().size(), 1U);
    const auto start = static_cast<std::size_t>(mock.converter.stream_starts()[0]) +
                       static_cast<std::size_t>(mock.settings.buffer_frames - mock.settings.ramp_frames());
    const alsa::PcmCodec codec{GetParam(), 0, mock.settings.full_scale_V};
    for (std::size_t i = 0; i < blocks * block; ++i) {
        const DacTick tick{static_cast<std::int64_t>(i)};
        const auto scaled = std::int64_t{codec.dithered(test_drive(tick.n), tick, 0)} << (32 - codec.bits());
        ASSERT_EQ(mock.first[start + i], scaled) << "sample " << i;
        const double tone =
            std::sin(2 * std::numbers::pi * std::fmod(1000.0 * static_cast<double>(i) / 48000, 1));
        const auto second = std::int64_t{codec.dithered(tone, tick, 1)} << (32 - codec.bits());
        ASSERT_NEAR(static_cast<double>(mock.second[start + i]), static_cast<double>(second),
                    std::ldexp(1.0, 32 - codec.bits()))
            << "sample " << i;
    }
    // Then the ramp, whose last samples round to zero: a few of 24 bits, up to 12 of 16.
    const std::size_t silent = start + blocks * block + 2400;
    EXPECT_LT(mock.end_of_sound(), silent);
    EXPECT_GT(mock.end_of_sound(), silent - 20);
}

INSTANTIATE_TEST_SUITE_P(Formats, AlsaFormatTest,
                         testing::Values(alsa::SampleFormat::s32, alsa::SampleFormat::s24,
                                         alsa::SampleFormat::s24_3, alsa::SampleFormat::s16),
                         [](const auto& p) { return std::string{to_text(p.param)}; });

TEST(AlsaDacTest, TicksMatchTheConverter) {
    MockDac mock;
    alsa::AlsaDac dac{mock.settings};
    Player player{dac};
    for (int i = 0; i < 30; ++i) {
        const PlayTime played = player.play();
        mock.listen();
        const std::int64_t first = mock.converter.stream_starts().at(0) + 7200;  // of tick 0
        // A stamp is later than its tick by the duration of reading clock and pointer, never earlier.
        const auto behind = played.heard - mock.converter.time_of(first + played.tick.n);
        EXPECT_GE(behind.count(), -1000);  // ns
    }
}

TEST(AlsaDacTest, AClockErrorOf37PpmIsFoundWithin1Ppm) {
    MockDac mock{37.5};
    alsa::AlsaDac dac{mock.settings};
    Player player{dac};
    calibration::ClockTracker<DacClock> tracker{48000};
    for (int i = 0; i < 420; ++i) {
        const PlayTime played = player.play();
        if (!test::in_real_time) continue;
        ASSERT_EQ(played.lost, 0);
        tracker.add(played.tick, played.heard);
    }
    if (!test::in_real_time) return;
    std::printf("clock error %.3f ppm of 37.500, stamps late by %.1f us\n", tracker.ppm(),
                1e6 * tracker.residual().count());
    EXPECT_NEAR(tracker.ppm(), 37.5, 1);
}

TEST(AlsaDacTest, WriteDoesNotAllocate) {
    MockDac mock;
    alsa::AlsaDac dac{mock.settings};
    const std::vector<double> volts = test_block(0, block), still(block);
    dac.write(volts, still);
    const test::NoAlloc guard;
    for (int i = 0; i < 40; ++i) dac.write(volts, still);
}

}  // namespace
}  // namespace shaker::hardware
