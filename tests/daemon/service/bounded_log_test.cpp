#include "daemon/service/bounded_log.hpp"

#include <gtest/gtest.h>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdlib>
#include <memory>
#include <sstream>
#include <string>
#include <thread>

namespace shaker::service {
namespace {

struct BoundedLogTest : testing::Test {
    std::ostringstream out;

    std::shared_ptr<spdlog::logger> logger(LogRate rate) {
        auto inner = std::make_shared<spdlog::sinks::ostream_sink_mt>(out);
        auto log = std::make_shared<spdlog::logger>("test", bounded_sink(inner, rate));
        log->set_pattern("%v");
        return log;
    }
    [[nodiscard]] std::size_t lines() const {
        const std::string text = out.str();
        return static_cast<std::size_t>(std::ranges::count(text, '\n'));
    }
};

TEST_F(BoundedLogTest, ControlCharactersAreEscaped) {
    logger({})->info("from \"{}\"", "a\x1b[2Jb\nc\r\x7f\xc2\x9b");
    EXPECT_EQ(out.str(), "from \"a\\x1b[2Jb\\x0ac\\x0d\\u007f\\u009b\"\n");
}

TEST_F(BoundedLogTest, FloodIsCutAndOmissionsAreCounted) {
    const auto log = logger({.burst = 5, .per_s = 20});
    for (int i = 0; i < 1000; ++i) log->info("again");
    EXPECT_LE(lines(), 7U);
    EXPECT_GE(lines(), 5U);
    std::this_thread::sleep_for(std::chrono::milliseconds{200});
    log->info("later");
    EXPECT_NE(out.str().find("later (99"), std::string::npos) << out.str();
}

TEST_F(BoundedLogTest, ErrorsAlwaysPass) {
    const auto log = logger({.burst = 1, .per_s = 0});
    for (int i = 0; i < 10; ++i) log->error("broken");
    EXPECT_EQ(lines(), 10U);
}

// A program whose standard error nobody reads ends nevertheless.
TEST(StandardErrorTest, PipeThatNobodyReadsHoldsUpTheEndForASecond) {
    std::array<int, 2> pipe{};
    ASSERT_EQ(::pipe(pipe.data()), 0);
    const int before = ::dup(STDERR_FILENO);
    const char* journal = std::getenv("JOURNAL_STREAM");
    const std::string stream = journal == nullptr ? "" : journal;
    ::unsetenv("JOURNAL_STREAM");
    ::dup2(pipe[1], STDERR_FILENO);
    const auto begin = std::chrono::steady_clock::now();
    {
        const BoundedLog log;
        for (int i = 0; i < 90; ++i) spdlog::info("{} {}", i, std::string(2000, 'x'));
    }
    const auto took = std::chrono::steady_clock::now() - begin;
    ::dup2(before, STDERR_FILENO);
    spdlog::set_default_logger(std::make_shared<spdlog::logger>("after"));
    if (!stream.empty()) ::setenv("JOURNAL_STREAM", stream.c_str(), 1);
    std::string got(1U << 20U, '\0');
    ::close(pipe[1]);
    got.resize(static_cast<std::size_t>(std::max<ssize_t>(0, ::read(pipe[0], got.data(), got.size()))));
    ::close(pipe[0]);
    ::close(before);
    EXPECT_LT(took, std::chrono::seconds{3});
    EXPECT_EQ(got.substr(0, 4), "0 xx") << "what it took is there";
    EXPECT_GT(got.size(), 3000U);
}

}  // namespace
}  // namespace shaker::service
