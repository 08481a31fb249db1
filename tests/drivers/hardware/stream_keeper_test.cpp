#include "drivers/hardware/alsa/stream_keeper.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <csignal>
#include <optional>
#include <utility>

namespace shaker::hardware {
namespace {

using std::chrono::steady_clock;

/// A descriptor to keep. The other end reads end of file when no process has it any more.
struct Kept {
    std::array<int, 2> ends{-1, -1};
    Kept() { EXPECT_EQ(::pipe2(ends.data(), O_CLOEXEC), 0); }
    Kept(const Kept&) = delete;
    Kept& operator=(const Kept&) = delete;
    ~Kept() {
        for (const int end : ends) ::close(end);
    }
    void let_go() { ::close(std::exchange(ends[1], -1)); }
    [[nodiscard]] bool gone_within(std::chrono::milliseconds wait) const {
        pollfd end{.fd = ends[0], .events = POLLIN, .revents = 0};
        return ::poll(&end, 1, static_cast<int>(wait.count())) > 0;
    }
};

constexpr std::chrono::milliseconds patience{10000};

/// A process that keeps the descriptor and is then killed.
void keep_and_die(Kept& kept, Seconds lasts) {
    std::array<int, 2> ready{};
    ASSERT_EQ(::pipe2(ready.data(), O_CLOEXEC), 0);
    const pid_t process = ::fork();
    if (process == 0) {
        const alsa::StreamKeeper controller{kept.ends[1], lasts};
        static_cast<void>(!::write(ready[1], "!", 1));
        for (;;) ::pause();
    }
    char told = 0;
    EXPECT_EQ(::read(ready[0], &told, 1), 1);
    kept.let_go();
    EXPECT_FALSE(kept.gone_within(std::chrono::milliseconds{0}));
    ::kill(process, SIGKILL);
    ::waitpid(process, nullptr, 0);
    for (const int end : ready) ::close(end);
}

TEST(StreamKeeperTest, DescriptorOutlivesKilledProcess) {
    Kept kept;
    const auto before = steady_clock::now();
    keep_and_die(kept, Seconds{0.4});
    EXPECT_TRUE(kept.gone_within(patience));
    EXPECT_GE(Seconds{steady_clock::now() - before}.count(), 0.4);
}

TEST(StreamKeeperTest, ReleasesDescriptorWithItsOwner) {
    Kept kept;
    std::optional<alsa::StreamKeeper> controller{std::in_place, kept.ends[1], Seconds{60}};
    kept.let_go();
    EXPECT_FALSE(kept.gone_within(std::chrono::milliseconds{50}));
    controller.reset();
    EXPECT_TRUE(kept.gone_within(std::chrono::milliseconds{0}));
}

}  // namespace
}  // namespace shaker::hardware
