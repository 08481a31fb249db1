// Hard stops on the mock converter: what is heard is the recorded drive, and it is silent in time.
#include <alsa/asoundlib.h>
#include <dlfcn.h>
#include <gtest/gtest.h>

#include <cerrno>
#include <cmath>
#include <cstdio>
#include <thread>
#include <utility>

#include "drivers/hardware/alsa/alsa_dac.hpp"
#include "drivers/hardware/alsa/output_frames.hpp"
#include "tests/support/devices/hard_stops.hpp"
#include "tests/support/devices/mock_dac.hpp"
#include "tests/support/in_real_time.hpp"
#include "tests/support/no_alloc.hpp"
#include "tests/support/remote/player.hpp"
#include "tests/support/stall_probe.hpp"

namespace {

int rewinds_until_failure = 0;  // 0: none fails

}  // namespace

// Replaces the function of libasound.
extern "C" snd_pcm_sframes_t snd_pcm_rewind(snd_pcm_t* pcm, snd_pcm_uframes_t frames) {
    static const auto real =
        reinterpret_cast<decltype(&snd_pcm_rewind)>(::dlsym(RTLD_NEXT, "snd_pcm_rewind"));
    if (rewinds_until_failure > 0 && --rewinds_until_failure == 0) return -EIO;
    return real(pcm, frames);
}

namespace shaker::hardware {
namespace {

using test::MockDac;
using test::Player;

constexpr int aborts = 40;

alsa::AlsaSettings short_buffer(const MockDac& mock) {
    alsa::AlsaSettings s = mock.settings;
    s.period_frames = 240;
    s.buffer_frames = 4800;
    s.dither = false;
    return s;
}

TEST(AlsaTakeBackTest, HardStopsAreHeardAsRecorded) {
    MockDac mock;
    const alsa::AlsaSettings s = short_buffer(mock);
    test::HardStops all;
    {
        alsa::AlsaDac dac{s};
        const std::jthread listener{[&](const std::stop_token& stop) {
            while (!stop.stop_requested()) mock.listen_for(Seconds{0.1});
        }};
        all = test::stop_hard(dac, aborts, 1);
    }
    mock.listen();
    if (!test::in_real_time) return;
    ASSERT_EQ(all.counts.incidents, 0U);
    ASSERT_EQ(all.counts.taken, all.volts.size());
    ASSERT_EQ(all.stops.size(), static_cast<std::size_t>(aborts));
    const double block_s = 0.005, margin_s = 2.0 * s.period_frames / s.rate_hz, ramp_s = 0.005;
    std::size_t in_time = 0, stalled = 0;
    double worst_s = 0;
    for (const test::HardStop& stop : all.stops) {
        EXPECT_GT(stop.taken_back, 0);
        EXPECT_EQ(stop.ramp, 240);
        if (stop.stalled) {
            ++stalled;
            continue;
        }
        worst_s = std::max(worst_s, stop.silent_s);
        in_time += stop.silent_s < block_s + margin_s + ramp_s + 1e-3 ? 1 : 0;
    }
    std::printf("%zu of %zu silent within %.0f ms, the slowest after %.1f ms; %zu more beside a stall\n",
                in_time, all.stops.size() - stalled, 1e3 * (block_s + margin_s + ramp_s), 1e3 * worst_s,
                stalled);
    EXPECT_LT(worst_s, block_s + margin_s + ramp_s + Seconds{test::StallProbe::least}.count());
    EXPECT_LT(all.largest_step, all.own_step);
    EXPECT_GE(in_time, all.stops.size() * 9 / 10) << "the others waited for a processor";
    const auto start = static_cast<std::size_t>(mock.converter.stream_starts().at(0)) +
                       static_cast<std::size_t>(s.buffer_frames - s.ramp_frames());
    const alsa::PcmCodec codec{s.format, 0, s.full_scale_V};
    for (std::size_t i = 0; i < all.volts.size(); ++i)
        ASSERT_EQ(mock.first[start + i], std::int64_t{codec.code(all.volts[i])} << (32 - codec.bits())) << i;
}

TEST(AlsaTakeBackTest, ToneAndTriggerFollowTheDrive) {
    for (const auto second : {alsa::SecondChannel::tone, alsa::SecondChannel::trigger}) {
        MockDac mock;
        alsa::AlsaSettings s = short_buffer(mock);
        s.second_channel = second;
        std::vector<double> volts, pulses;
        {
            alsa::AlsaDac dac{s};
            const std::vector<double> block = test::test_block(0, 480);
            for (int k = 0; k < 60; ++k) {
                std::vector<double> trigger(block.size());
                for (std::size_t i = 7; i < block.size(); i += 48) trigger[i] = 1;
                dac.write(block, trigger);
                volts.insert(volts.end(), block.begin(), block.end());
                pulses.insert(pulses.end(), trigger.begin(), trigger.end());
                if (k % 20 != 19) continue;
                const std::int64_t taken = dac.take_back(1000);  // ends inside a pulse or beside it
                ASSERT_TRUE(taken > 0 || !test::in_real_time);
                const auto n = static_cast<std::size_t>(taken);
                const std::vector<double> again(volts.end() - taken, volts.end());
                const std::vector<double> pulses_again(pulses.end() - taken, pulses.end());
                dac.write(std::span{again}.first(n / 2), std::span{pulses_again}.first(n / 2));
                dac.write(std::span{again}.subspan(n / 2), std::span{pulses_again}.subspan(n / 2));
            }
            if (!test::in_real_time) continue;
            ASSERT_EQ(dac.counts().incidents, 0U);
            ASSERT_EQ(dac.counts().taken, volts.size());
        }
        mock.listen();
        const auto start = static_cast<std::size_t>(mock.converter.stream_starts().at(0)) +
                           static_cast<std::size_t>(s.buffer_frames - s.ramp_frames());
        std::int64_t high = 0;  // samples left of a pulse of 0.1 ms
        for (std::size_t i = 0; i < volts.size(); ++i) {
            if (pulses[i] > 0.5) high = 5;
            const double tone = std::sin(2 * std::numbers::pi * std::fmod(static_cast<double>(i) / 48, 1));
            const double want = second == alsa::SecondChannel::tone ? tone : high > 0 ? 1 : 0;
            high -= high > 0 ? 1 : 0;
            ASSERT_NEAR(static_cast<double>(mock.first[start + i]) / 0x1p31, volts[i], 1e-6) << i;
            ASSERT_NEAR(static_cast<double>(mock.second[start + i]) / 0x1p31, want, 1e-6) << i;
        }
    }
}

// Enabled, taken back, written again and enabled, then not enabled: the tone is exact, and it lasts to the
// end of the ramp of a DAC that is given no more samples.
TEST(AlsaTakeBackTest, EnableToneFollowsTheDrive) {
    for (const bool ends_enabled : {true, false}) {
        MockDac mock;
        alsa::AlsaSettings s = short_buffer(mock);
        s.enable_channel = 3;
        std::int64_t on = 0, off = 0, end = 0;
        {
            alsa::AlsaDac dac{s};
            EXPECT_EQ(dac.info().enable_before_s, 0.25);
            const std::vector<double> block = test::test_block(0, 480), still(480);
            const auto play = [&](int blocks) {
                for (int k = 0; k < blocks; ++k, end += 480) dac.write(block, still);
            };
            play(20);
            on = end;
            dac.enable(true);
            play(40);
            end -= dac.take_back(1000);
            play(20);
            off = end;
            dac.enable(ends_enabled);
            play(5);
            if (!test::in_real_time) continue;
            ASSERT_EQ(dac.counts().incidents, 0U);
        }
        mock.listen();
        const auto start = static_cast<std::size_t>(mock.converter.stream_starts().at(0)) +
                           static_cast<std::size_t>(s.buffer_frames - s.ramp_frames());
        if (ends_enabled) off = end + s.ramp_frames();
        for (std::int64_t i = 0; i < std::ssize(mock.third) - static_cast<std::int64_t>(start); ++i) {
            const double tone = std::sin(2 * std::numbers::pi * std::fmod(static_cast<double>(i) / 48, 1));
            ASSERT_NEAR(static_cast<double>(mock.third[start + static_cast<std::size_t>(i)]) / 0x1p31,
                        i >= on && i < off ? tone : 0, 1e-6)
                << i;
        }
    }
}

TEST(AlsaTakeBackTest, KeepsTwoPeriodsAndRampFollows) {
    MockDac mock;
    const alsa::AlsaSettings s = short_buffer(mock);
    std::int64_t end = 0;
    {
        alsa::AlsaDac dac{s};
        Player player{dac};
        player.play(40);
        const std::int64_t taken = dac.take_back(1 << 20);
        end = player.next - taken;
        EXPECT_TRUE(taken > 0 || !test::in_real_time);
        EXPECT_LE(taken, dac.info().queue_frames - dac.info().kept_frames);
        EXPECT_EQ(dac.info().kept_frames, 480);
        EXPECT_EQ(dac.take_back(1 << 20), 0) << "the rest stays";
        if (!test::in_real_time) return;
        ASSERT_EQ(dac.counts().incidents, 0U);
    }
    mock.listen();
    const auto start = static_cast<std::size_t>(mock.converter.stream_starts().at(0)) +
                       static_cast<std::size_t>(s.buffer_frames - s.ramp_frames());
    const std::size_t last = start + static_cast<std::size_t>(end);
    EXPECT_LT(mock.end_of_sound(), last + 2400);
    EXPECT_GT(mock.end_of_sound(), last + 2300);
    const double own = 1.02 * test::steepest_step;
    EXPECT_LE(mock.largest_step(start, mock.first.size()), own) << "neither value nor slope jumps";
}

// A rewind of the silence behind the ramp fails: no drive may sound behind that ramp, and the loss is
// reported.
TEST(AlsaTakeBackTest, SilenceThatStaysIsLostAndEndsTheDrive) {
    for (const int buffer : {4800, 9600, 4320}) {
        SCOPED_TRACE(buffer);
        MockDac mock;
        alsa::AlsaSettings s = short_buffer(mock);
        s.buffer_frames = buffer;
        PlayTime after;
        std::int64_t stays = 0;
        {
            alsa::AlsaDac dac{s};
            Player player{dac};
            player.play(40);
            rewinds_until_failure = 2;
            const std::int64_t taken = dac.take_back(1 << 20);
            stays = player.next - taken;
            ASSERT_TRUE(taken > 0 || !test::in_real_time);
            const bool was_empty = std::exchange(rewinds_until_failure, 0) > 0;
            if (was_empty || !test::in_real_time) continue;
            const std::vector<double> volts = test::test_block(stays, 240), still(240);
            after = dac.write(volts, still);
            EXPECT_GE(after.lost, taken) << "its caller must start again from silence";
            EXPECT_EQ(dac.take_back(1 << 20), 0);
            EXPECT_EQ(dac.counts().incidents, 1U);
            EXPECT_EQ(dac.counts().lost, static_cast<std::uint64_t>(after.lost + 240));
            for (int k = 0; k < 20; ++k) dac.write(still, still);
            EXPECT_EQ(dac.counts().incidents, 1U);
        }
        mock.listen();
        const auto start = static_cast<std::size_t>(mock.converter.stream_starts().at(0)) +
                           static_cast<std::size_t>(s.buffer_frames - s.ramp_frames());
        EXPECT_LE(mock.end_of_sound(), start + static_cast<std::size_t>(stays + s.ramp_frames()));
        EXPECT_LE(mock.largest_step(start, mock.first.size()), 1.02 * test::steepest_step);
    }
}

TEST(AlsaTakeBackTest, NothingIsTakenBackWithoutRamp) {
    MockDac mock;
    alsa::AlsaSettings s = short_buffer(mock);
    s.ramp_s = 0;
    alsa::AlsaDac dac{s};
    Player player{dac};
    player.play(40);
    EXPECT_FALSE(dac.info().takes_back());
    EXPECT_EQ(dac.take_back(1000), 0);
    EXPECT_NE(dac.granted().text().find("up to 100.0 ms later"), std::string::npos) << dac.granted().text();
}

TEST(AlsaTakeBackTest, UnpluggedDeviceTakesNothingBack) {
    MockDac mock;
    alsa::AlsaDac dac{short_buffer(mock)};
    Player player{dac};
    player.play(40);
    mock.converter.unplug();
    EXPECT_EQ(dac.take_back(1000), 0);
}

TEST(AlsaTakeBackTest, DoesNotAllocate) {
    MockDac mock;
    alsa::AlsaDac dac{short_buffer(mock)};
    const std::vector<double> volts = test::test_block(0, 480), still(480);
    for (int i = 0; i < 20; ++i) dac.write(volts, still);
    std::int64_t taken = 0;
    const test::NoAlloc guard;
    for (int i = 0; i < 50 && taken == 0; ++i) {  // 0: this thread stood still until the queue was empty
        taken = dac.take_back(1000);
        dac.write(volts, still);
    }
    EXPECT_GT(taken, 0);
}

}  // namespace
}  // namespace shaker::hardware
