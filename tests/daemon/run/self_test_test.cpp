// The commands of the self-test on hand-made streams.
#include "daemon/run/self_test.hpp"

#include <gtest/gtest.h>

#include "daemon/run/sequence.hpp"

namespace shaker::run {
namespace {

constexpr double rate_hz = 48000;
constexpr std::int64_t tenth = 4800;  // samples

struct SelfTestTest : testing::Test {
    SelfTest self_test{{.frequency = 1}, rate_hz};
    acquisition::Streams streams;
    Mailbox<DriveCommand> drive;
    std::int64_t played = 0;

    /// Plays a tenth of a second at a time until a command comes, which then takes effect.
    DriveCommand next(double limit_s = 100) {
        for (const std::int64_t end = played + static_cast<std::int64_t>(limit_s * rate_hz); played < end;) {
            played += tenth;
            streams.played.push_back({.tick = DacTick{played}, .heard = {}});
            self_test.step(streams, drive);
            const auto command = drive.take();
            if (!command) continue;
            streams.changes.push_back({.command = *command,
                                       .first = DacTick{played},
                                       .stop = static_cast<std::int64_t>(command->stop_s * rate_hz)});
            return *command;
        }
        ADD_FAILURE() << "no command";
        return {};
    }
};

TEST_F(SelfTestTest, InterruptAtOneHertzEndsWithinTwoSeconds) {
    EXPECT_GT(next().volts.order(), 0);
    self_test.leave(drive);
    EXPECT_EQ(next(1).stop_s, longest_soft_stop_s);
}

TEST_F(SelfTestTest, EndAtOneHertzTakesTwoSeconds) {
    EXPECT_GT(next().volts.order(), 0);
    EXPECT_EQ(next().stop_s, longest_soft_stop_s);
    self_test.leave(drive);
    EXPECT_FALSE(drive.take()) << "it comes down already";
}

}  // namespace
}  // namespace shaker::run
