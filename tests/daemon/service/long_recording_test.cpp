// A recording of minutes: memory, and results of measurements whose data left the memory.
#include <gtest/gtest.h>
#include <malloc.h>

#include "daemon/commands/replay.hpp"
#include "daemon/recording/tables/measured_tables.hpp"
#include "tests/support/program.hpp"
#include "tests/support/run/bench_on_call.hpp"

namespace shaker::service {
namespace {

using test::Answers;
using test::in;
using test::orders;

// An empty DAC shifts the clocks of the recording.
constexpr const char* scene =
    "[top]\npositions = 1\nframe_rate_hz = 200\n[side]\npositions = 1\nframe_rate_hz = 200\n"
    "[[fault]]\nwhat = \"underrun\"\nat_s = 30\nvalue = 2000\n";

// Memory in use by this program; what earlier tests have freed does not count.
double heap_bytes() {
    const auto heap = ::mallinfo2();
    return static_cast<double>(heap.uordblks) + static_cast<double>(heap.hblkhd);
}

// The operator records from idle to the end at to_s. look: called every 10 s.
test::OnCallResult record(const std::filesystem::path& folder, double to_s,
                          const std::function<void()>& look) {
    run::RunOptions run;
    run.pictures = recorded::KeptPictures::off;
    run.plan.periods = 40;
    run.drive.gamma = 1;  // the walker rests on the base, so that it stays in view
    Answers answers;
    std::vector<test::Move> moves{
        {in(run::RunState::idle), orders(Record{true, "long", recorded::KeptPictures::off}, answers)},
        {in(run::RunState::idle), orders(Begin{40}, answers)}};
    for (double t_s = 10; t_s < to_s; t_s += 10)
        moves.push_back(
            {[t_s](const BenchState& s) { return s.now_s > t_s; }, [look](BenchPort&) { look(); }});
    moves.push_back({in(run::RunState::run), orders(End{}, answers)});
    moves.push_back({in(run::RunState::idle), [](BenchPort&) {}});
    auto result = test::play_on_call(scene, run, folder, moves, to_s + 10);
    EXPECT_EQ(answers, Answers(3, ""));
    return result;
}

TEST(LongRecordingTest, MemoryStaysFlatAndReplayIsIdentical) {
    if (SHAKER_SANITIZED) GTEST_SKIP() << "a sanitiser keeps what was freed";
    const auto folder = test::fresh_folder();
    std::vector<double> bytes;  // every 10 s
    record(folder, 110, [&] { bytes.push_back(heap_bytes()); });
    ASSERT_EQ(bytes.size(), 10U);
    // Over an hour it is less than 10 kB/s: tests/bench/run recording_hour.
    EXPECT_LT((bytes[9] - bytes[4]) / 50, 10e3) << "bytes per second from 50 s to 100 s";
    const recorded::RecordingReader file{folder / "long.nxs"};
    EXPECT_GT(recording::read_finished(file).size(), 40U);
    EXPECT_EQ(file.numbers("gaps/first").size(), 1U);
    EXPECT_TRUE(commands::replay({.file = folder / "long.nxs", .json = true}));
}

}  // namespace
}  // namespace shaker::service
