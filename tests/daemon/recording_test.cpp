// A recording that is fed faster than it is written: what finds no room is counted in the file.
#include "daemon/recording.hpp"

#include <gtest/gtest.h>

#include "daemon/session_places.hpp"
#include "drivers/errors.hpp"
#include "tests/replay/small_session.hpp"
#include "tests/support/program.hpp"

namespace shaker {
namespace {

SessionHeader header() {
    SessionHeader h = session_test::small_header();
    h.pictures = KeptPictures::off;
    h.groups = session_places(h, false);
    return h;
}

TEST(RecordingTest, WhatFindsNoRoomIsCountedInTheFile) {
    const std::filesystem::path file = test::fresh_folder() / "run.nxs";
    constexpr std::int64_t plays = 70000;
    Recording recording{file, header(), {.live = true}};
    for (std::int64_t n = 0; n < plays; ++n)
        recording.add(PlayTime{{n}, HostTime{std::chrono::nanoseconds{20000 * n}}});
    EXPECT_GT(recording.backlog(), 0.99);
    EXPECT_FALSE(recording.failure());
    recording.finish(Take{});
    const SessionReader read{file};
    const std::size_t kept = read.play_times().size();
    EXPECT_GT(kept, 65000U);
    EXPECT_LT(kept, static_cast<std::size_t>(plays));
    EXPECT_EQ(static_cast<double>(kept) + read.scalar("process/pieces_lost"), plays);
    EXPECT_EQ(read.damage(), std::vector<std::string>{});
}

TEST(RecordingTest, WithoutAFileNothingIsDone) {
    Recording recording{{}, header(), {}};
    recording.add(PlayTime{{7}, {}});
    EXPECT_FALSE(recording.on());
    EXPECT_FALSE(recording.step());
    recording.finish(Take{});
}

TEST(RecordingTest, LessRoomThanMustStayFreeIsRefusedWithFigures) {
    const std::filesystem::path file = test::fresh_folder() / "run.nxs";
    try {
        Recording recording{file, header(), {.least_free_bytes = std::uint64_t{1} << 60U}};
        FAIL() << "it was begun";
    } catch (const InputError& e) {
        session_test::expect_in(e.what(), {"run.nxs", "free", "1152921504.61 GB"});
    }
    EXPECT_FALSE(std::filesystem::exists(file.string() + ".part"));
}

}  // namespace
}  // namespace shaker
