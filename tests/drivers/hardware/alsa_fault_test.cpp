#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "drivers/errors.hpp"
#include "drivers/hardware/alsa/alsa_dac.hpp"
#include "drivers/hardware/alsa/output_frames.hpp"
#include "tests/support/devices/mock_dac.hpp"
#include "tests/support/in_real_time.hpp"
#include "tests/support/remote/player.hpp"

namespace shaker::hardware {
namespace {

using test::MockDac;
using test::Player;
using test::test_drive;
constexpr std::int64_t live = 7200;  // samples of the drive in MockDac's buffer; the ramp has 2400

void pause_for(double seconds) { std::this_thread::sleep_for(Seconds{seconds}); }

/// Delay of the drive at `tick` relative to the time base of the first stream, samples. Searches 2 periods of
/// the drive with 480 samples each.
std::int64_t misplaced(const MockDac& mock, std::int64_t tick) {
    const alsa::PcmCodec codec{alsa::SampleFormat::s32, 0, 1};
    const std::int64_t place = mock.converter.stream_starts().at(0) + live + tick;
    for (std::int64_t off = 0; off<960; off = off> 0 ? -off : 1 - off) {
        bool same = true;
        for (std::int64_t i = 0; same && i < 480; ++i) {
            const DacTick t{tick + i};
            same = mock.first.at(static_cast<std::size_t>(place + off + i)) ==
                   std::int64_t{codec.dithered(test_drive(t.n), t, 0)} * 256;
        }
        if (same) return off;
    }
    return 999999;
}

/// After an error: counted once, ticks correct, equal lost time in report and output.
void expect_one_gap(MockDac& mock, const alsa::AlsaDac& dac, const Player& player,
                    std::int64_t places_within) {
    ASSERT_EQ(player.lost.size(), 1U);
    EXPECT_EQ(dac.counts().incidents, 1U);
    EXPECT_EQ(dac.counts().reopened, 0U);
    EXPECT_LE(std::abs(misplaced(mock, player.resumed[0])), places_within);
    const std::size_t drive_begins = static_cast<std::size_t>(
        mock.converter.stream_starts()[0] + live + player.resumed[0] + misplaced(mock, player.resumed[0]));
    EXPECT_EQ(mock.first[drive_begins - 1], 0);  // from silence
    EXPECT_EQ(dac.counts().taken + dac.counts().lost, static_cast<std::uint64_t>(player.next));
}

TEST(AlsaFaultTest, CountsUnderrunAndReportsNextBlock) {
    MockDac mock;
    alsa::AlsaDac dac{mock.settings};
    Player player{dac};
    player.play(30);
    mock.converter.cause_underrun();
    player.play(60);
    pause_for(0.16);
    mock.listen();
    if (!test::in_real_time) return;  // a slow test has underruns of its own
    EXPECT_EQ(mock.converter.counts().underruns, 1U);
    EXPECT_EQ(mock.converter.counts().streams, 2U);
    expect_one_gap(mock, dac, player, 5);
}

TEST(AlsaFaultTest, DropsBlockThatArrivesDuringRamp) {
    MockDac mock;
    mock.settings.buffer_frames = 11040;
    mock.settings.ramp_s = 0.08;  // 3840 samples: 80 ms to hit, and `live` as in the other tests
    alsa::AlsaDac dac{mock.settings};
    Player player{dac};
    player.play(30);
    pause_for(0.18);
    player.play(40);
    pause_for(0.16);
    mock.listen();
    if (!test::in_real_time) return;
    // Within one stream all times are exact; a machine that paused longer than the buffer has an underrun.
    expect_one_gap(mock, dac, player, mock.converter.counts().streams == 1 ? 0 : 5);
    const auto resumed = mock.converter.stream_starts()[0] + live + player.resumed[0];
    EXPECT_LT(mock.largest_step(0, static_cast<std::size_t>(resumed) - 5), 1.001 * test::steepest_step);
}

TEST(AlsaFaultTest, DetectsStalledDeviceByItsClock) {
    MockDac mock;
    alsa::AlsaDac dac{mock.settings};
    Player player{dac};
    player.play(60);
    mock.converter.stall(Seconds{0.1});
    player.play(60);
    pause_for(0.16);
    mock.listen();
    if (!test::in_real_time) return;
    EXPECT_EQ(mock.converter.counts().streams, 1U);
    expect_one_gap(mock, dac, player, 10);
}

TEST(AlsaFaultTest, ReopensAndGivesUpStalledDevice) {
    MockDac mock;
    mock.settings.buffer_frames = 4800;
    mock.settings.ramp_s = 0.02;
    alsa::AlsaDac dac{mock.settings};
    Player player{dac};
    player.play(20);
    mock.converter.stall(Seconds{1000});
    std::size_t writes = 0;
    EXPECT_THROW(
        {
            for (; writes < 100; ++writes) player.play();
        },
        DeviceError);
    EXPECT_LE(writes, 20U);
    EXPECT_EQ(dac.counts().reopened, 1U);
    EXPECT_GE(dac.counts().incidents, 6U);
    EXPECT_LE(dac.counts().taken,
              20 * Player::block);  // unplayed silence does not count as lost
}

TEST(AlsaFaultTest, ReportsUnpluggedDeviceAndReopens) {
    MockDac mock;
    {
        alsa::AlsaDac dac{mock.settings};
        Player player{dac};
        player.play(20);
        mock.converter.unplug();
        try {
            player.play(3);
            FAIL() << "nothing was thrown";
        } catch (const DeviceError& e) {
            EXPECT_NE(std::string{e.what()}.find("shaker"), std::string::npos) << e.what();
            EXPECT_NE(std::string{e.what()}.find("No such device"), std::string::npos) << e.what();
        }
        EXPECT_THROW(alsa::AlsaDac{mock.settings}, DeviceError);
    }
    mock.converter.plug();
    alsa::AlsaDac dac{mock.settings};
    EXPECT_EQ(Player{dac}.play(20).lost, 0);
}

TEST(AlsaFaultTest, StopUnblocksWriteToStalledDevice) {
    MockDac mock;
    mock.settings.buffer_frames = 24000;  // write() would wait 1 s and count that as an incident
    alsa::AlsaDac dac{mock.settings};
    Player player{dac};
    player.play(2);
    mock.converter.stall(Seconds{1000});
    std::atomic<bool> over = false;
    std::jthread writer{[&] {
        while (!over) {
            player.play();
            if (dac.counts().taken > 1000000) break;
        }
    }};
    pause_for(0.1);
    over = true;
    dac.stop();
    writer.join();
    if (!test::in_real_time)
        return;  // a slow test writes once more after the stall, which is then an incident
    EXPECT_EQ(dac.counts().incidents, 0U);
}

TEST(AlsaFaultTest, AfterStopTheDriveEndsInTheRamp) {
    MockDac mock;
    {
        alsa::AlsaDac dac{mock.settings};
        Player player{dac};
        std::jthread stopper{[&] {
            pause_for(0.3);
            dac.stop();
        }};
        for (int i = 0; i < 60; ++i) player.play();
        EXPECT_LT(dac.counts().taken, 60 * Player::block);
    }
    mock.listen();
    EXPECT_LT(mock.largest_step(0, mock.first.size()), 1.001 * test::steepest_step);
    EXPECT_EQ(mock.first.back(), 0);
}

}  // namespace
}  // namespace shaker::hardware
