// What is heard when the process that drives dies, is stopped or hangs: judged at the mock converter's own
// samples, which go on without the process.
#include <gtest/gtest.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <thread>

#include "drivers/hardware/alsa_dac.hpp"
#include "tests/support/mock_dac.hpp"
#include "tests/support/player.hpp"

namespace shaker {
namespace {

using test::MockDac;
using test::Player;

// Dither adds two steps of 24 bits. The ramp's own steps are a hundredth of this, a cut would be up to 0.5.
constexpr double steepest = test::steepest_step;
constexpr std::size_t ten_ms = 480;

/// A process of its own that drives until `blocks` are written, then does nothing for ever.
class Driving {
public:
    Driving(const AlsaSettings& settings, std::size_t blocks) : pid_{::fork()} {
        if (pid_ != 0) return;
        ::prctl(PR_SET_PDEATHSIG, SIGKILL);
        try {
            AlsaDac dac{settings};
            Player{dac}.play(blocks);
            for (;;) ::pause();
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

std::size_t due_now(const MockDac& mock) {
    return static_cast<std::size_t>(
        mock.converter.due(HostTime{std::chrono::steady_clock::now().time_since_epoch()}));
}

void expect_silence_after(MockDac& mock, std::size_t end) {
    mock.listen_for(Seconds{0.35});
    ASSERT_LT(mock.next_sound(0), end) << "it never drove";
    EXPECT_GT(mock.largest_step(0, mock.first.size()), 0.9 * steepest) << "it did not drive at level";
    EXPECT_LE(mock.end_of_sound(), end + static_cast<std::size_t>(mock.settings.buffer_frames) + ten_ms);
    EXPECT_LT(mock.largest_step(0, mock.first.size()), 1.001 * steepest);
    EXPECT_EQ(mock.converter.counts().replayed, 0U);
    EXPECT_EQ(mock.converter.counts().missed, 0U);
}

constexpr std::size_t for_ever = 1U << 30U;

TEST(AlsaDeathTest, AKilledProcessLeavesARamp) {
    for (const double after_s : {0.4, 0.4037, 0.4071}) {  // at several phases of drive and block
        MockDac mock;
        const Driving driving{mock.settings, for_ever};
        mock.listen_for(Seconds{after_s});
        driving.signal(SIGKILL);
        expect_silence_after(mock, due_now(mock));
    }
}

TEST(AlsaDeathTest, AStoppedProcessLeavesARampAndDoesNotGoOnAtLevel) {
    MockDac mock;
    const Driving driving{mock.settings, for_ever};
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

TEST(AlsaDeathTest, AWriterThatHangsLeavesARamp) {
    MockDac mock;
    constexpr std::size_t blocks = 37;
    const Driving driving{mock.settings, blocks};
    mock.listen_for(Seconds{0.6});
    const auto drive = static_cast<std::size_t>(mock.converter.stream_starts().at(0)) + 7200;
    expect_silence_after(mock, drive + blocks * Player::block);
    // All that was written is heard, then half of the ramp's samples are above half of its height or so: the
    // ramp is there and has its length.
    EXPECT_LT(mock.end_of_sound(), drive + blocks * Player::block + 2400);
    EXPECT_GT(mock.end_of_sound(), drive + blocks * Player::block + 2300);
}

}  // namespace
}  // namespace shaker
