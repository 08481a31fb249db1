// Output when the driving process dies, is stopped or hangs: checked on the mock converter's samples, which
// continue without the process.
#include <gtest/gtest.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <functional>

#include "drivers/hardware/alsa/alsa_dac.hpp"
#include "drivers/hardware/alsa/output_frames.hpp"
#include "drivers/hardware/alsa/pcm.hpp"
#include "tests/support/devices/mock_dac.hpp"
#include "tests/support/in_real_time.hpp"
#include "tests/support/remote/player.hpp"

namespace shaker::hardware {
namespace {

using test::MockDac;
using test::Player;

// Dither adds two steps of 24 bits. The ramp's own steps are a hundredth of this, a cut would be up to 0.5.
constexpr double steepest = test::steepest_step;
constexpr std::size_t ten_ms = 480;

/// A separate process that plays a given drive.
class Driving {
public:
    explicit Driving(const std::function<void()>& drive) : pid_{::fork()} {
        if (pid_ != 0) return;
        ::prctl(PR_SET_PDEATHSIG, SIGKILL);
        try {
            drive();
        } catch (const std::exception& e) {
            std::fprintf(stderr, "the driving process: %s\n", e.what());
        }
        ::_exit(1);
    }
    Driving(const Driving&) = delete;
    Driving& operator=(const Driving&) = delete;
    ~Driving() {
        signal(SIGKILL);
        ::waitpid(pid_, nullptr, 0);
    }
    void signal(int number) const { ::kill(pid_, number); }

private:
    pid_t pid_;
};

[[noreturn]] void hang() {
    for (;;) ::pause();
}

/// Plays the test drive for a number of blocks, then nothing.
std::function<void()> drives(const alsa::AlsaSettings& settings, std::size_t blocks = 1U << 30U) {
    return [settings, blocks] {
        alsa::AlsaDac dac{settings};
        Player{dac}.play(blocks);
        hang();
    };
}

std::size_t due_now(const MockDac& mock) {
    return static_cast<std::size_t>(mock.converter.due(mock::host_now()));
}

void expect_silence_after(MockDac& mock, std::size_t end) {
    mock.listen_for(Seconds{0.35});
    ASSERT_LT(mock.next_sound(0), end) << "it never drove";
    EXPECT_GT(mock.largest_step(0, mock.first.size()), 0.9 * steepest) << "it did not drive at level";
    std::printf("silent %.1f ms after; largest step %.5f of full scale, the drive's own is %.5f\n",
                (static_cast<double>(mock.end_of_sound()) - static_cast<double>(end)) / 48,
                mock.largest_step(0, mock.first.size()), steepest);
    EXPECT_LE(mock.end_of_sound(), end + static_cast<std::size_t>(mock.settings.buffer_frames) + ten_ms);
    EXPECT_LT(mock.largest_step(0, mock.first.size()), 1.001 * steepest);
    EXPECT_EQ(mock.second.back(), 0);
    EXPECT_EQ(mock.converter.counts().replayed, 0U);
    EXPECT_EQ(mock.converter.counts().missed, 0U);
}

class AlsaDeathTest : public ::testing::Test {
protected:
    void SetUp() override {
        if (!test::in_real_time) GTEST_SKIP() << "judges real time, to the millisecond";
    }
};

TEST_F(AlsaDeathTest, KilledProcessLeavesRamp) {
    for (const double after_s : {0.4, 0.4037, 0.4071}) {  // at several phases of drive and block
        MockDac mock;
        const Driving driving{drives(mock.settings)};
        mock.listen_for(Seconds{after_s});
        driving.signal(SIGKILL);
        expect_silence_after(mock, due_now(mock));
    }
}

TEST_F(AlsaDeathTest, StoppedProcessLeavesRamp) {
    MockDac mock;
    const Driving driving{drives(mock.settings)};
    mock.listen_for(Seconds{0.4});
    driving.signal(SIGSTOP);
    expect_silence_after(mock, due_now(mock));
    const std::size_t woken = mock.first.size();
    driving.signal(SIGCONT);
    mock.listen_for(Seconds{0.4});
    const std::size_t again = mock.next_sound(woken);
    EXPECT_LT(again, mock.first.size()) << "it did not drive again";
    EXPECT_EQ(mock.converter.counts().streams, 2U);
}

TEST_F(AlsaDeathTest, HangingWriterLeavesRamp) {
    MockDac mock;
    constexpr std::size_t blocks = 37;
    const Driving driving{drives(mock.settings, blocks)};
    mock.listen_for(Seconds{0.6});
    const auto drive = static_cast<std::size_t>(mock.converter.stream_starts().at(0)) + 7200;
    expect_silence_after(mock, drive + blocks * Player::block);
    // All written samples are played, and the ramp without its last samples, which round to zero.
    EXPECT_LT(mock.end_of_sound(), drive + blocks * Player::block + 2400);
    EXPECT_GT(mock.end_of_sound(), drive + blocks * Player::block + 2300);
}

// Before a block is written, the ramp is taken back; before a hard stop, the drive in front of it as well.
class AlsaRewindDeathTest : public AlsaDeathTest, public testing::WithParamInterface<std::int64_t> {};

TEST_P(AlsaRewindDeathTest, StillPlaysDriveAndRamp) {
    MockDac mock;
    constexpr std::int64_t silence = 4800;
    const Driving driving{[&s = mock.settings, drive = GetParam()] {
        alsa::AlsaPcm pcm{s};
        const alsa::PcmCodec codec{s.format, 0, s.full_scale_V};
        alsa::OutputFrames frames{s, codec, 2, Player::block};
        const std::vector<double> still(Player::block);
        if (pcm.prepare() < 0 || pcm.write_silence(silence) != silence) return;
        if (pcm.write(frames.block(test::test_block(0, Player::block), still, {0})) < 0) return;
        if (pcm.start() < 0 || pcm.rewind(s.ramp_frames() + drive) < 0) return;
        hang();
    }};
    mock.listen_for(Seconds{0.3});
    const std::size_t end_of_drive =
        static_cast<std::size_t>(mock.converter.stream_starts().at(0) + silence) + Player::block;
    expect_silence_after(mock, end_of_drive);
    EXPECT_LT(mock.end_of_sound(), end_of_drive + 2400);
    EXPECT_GT(mock.end_of_sound(), end_of_drive + 2300);
}

INSTANTIATE_TEST_SUITE_P(SamplesOfTheDrive, AlsaRewindDeathTest, testing::Values(0, 400));

}  // namespace
}  // namespace shaker::hardware
