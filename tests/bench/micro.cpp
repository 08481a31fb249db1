// Single steps of the real-time path (Google Benchmark): hand-over, frame pool, synthesiser, guards, clock
// fit.
#include <benchmark/benchmark.h>

#include <array>

#include "calibration/clocks/clock_tracker.hpp"
#include "daemon/safety/output_guard.hpp"
#include "daemon/safety/sample_guard.hpp"
#include "drivers/frame_pool.hpp"
#include "drivers/handover.hpp"
#include "drivers/synthesiser.hpp"

namespace shaker {
namespace {

void BM_ring_push_and_pop_block(benchmark::State& state) {
    Ring<AccelBlock> ring{64};
    const AccelBlock block;
    for (auto _ : state) {
        benchmark::DoNotOptimize(ring.push(block));
        benchmark::DoNotOptimize(ring.pop());
    }
}
BENCHMARK(BM_ring_push_and_pop_block);

void BM_mailbox_post_and_take_command(benchmark::State& state) {
    Mailbox<DriveCommand> box;
    const DriveCommand command;
    for (auto _ : state) {
        box.post(command);
        benchmark::DoNotOptimize(box.take());
    }
}
BENCHMARK(BM_mailbox_post_and_take_command);

void BM_frame_pool_acquire_and_return(benchmark::State& state) {
    FramePool pool{32, 64, 64, 1};
    std::vector<FramePtr> held;
    for (std::int64_t i = 0; i < state.range(0); ++i) held.push_back(pool.acquire());
    for (auto _ : state) benchmark::DoNotOptimize(pool.acquire());
}
BENCHMARK(BM_frame_pool_acquire_and_return)->ArgName("out")->Arg(0)->Arg(31);

void BM_synthesiser_fill_256(benchmark::State& state) {
    Synthesiser synth{48000, 20, 2};
    DriveCommand command;
    for (int q = 1; q <= static_cast<int>(state.range(0)); ++q) command.volts.at(q) = {0.1, 0.02};
    command.ramp_periods = state.range(1) != 0 ? 100'000'000 : 1;
    synth.set(command);
    if (state.range(1) == 0) synth.skip(10000);
    std::array<double, 256> volts{};
    for (auto _ : state) {
        synth.fill(volts);
        benchmark::DoNotOptimize(volts);
    }
    state.SetItemsProcessed(state.iterations() * 256);
}
BENCHMARK(BM_synthesiser_fill_256)->ArgNames({"K", "ramped"})->ArgsProduct({{2, 8, 16}, {0, 1}});

/// Blocks of 64 samples of a driven base; `predicted`: number of harmonics in the prediction.
void BM_sample_guard_check_64(benchmark::State& state) {
    const auto harmonics = static_cast<int>(state.range(0));
    safety::Limits limits;
    limits.acceleration = limits.velocity = limits.displacement = {50, 100};
    safety::SampleGuard guard{
        {.name = "bench", .mps2_per_count = {1e-3, 1e-3, 1e-3}, .shaker_axis = {1, 0, 0}}, 48000, limits};
    DriveChange change{.command = {.volts = {}, .frequency = 20}, .first = {0}, .ramp = 2400};
    for (int q = 1; q <= harmonics; ++q) change.command.volts.at(q) = {0.1, 0.02};
    change.step = turns_per_sample(20, 48000);
    safety::Expectation expectation{.sigma = 0.01, .tolerance = 1e6};
    expectation.response.fill(10);
    guard.hear(change);
    if (harmonics > 0) guard.expect(expectation);
    AccelBlock block;
    for (int i = 0; i < block.size; ++i)
        block.counts[static_cast<std::size_t>(i)] = {i * 37 % 100, i * 53 % 100, 9800 + i % 3};
    Ring<safety::Trip> trips{8};
    safety::Warnings warnings;
    for (auto _ : state) {
        guard.check(block, trips, warnings);
        block.first.n += block.size;
    }
    state.SetItemsProcessed(state.iterations() * block.size);
}
BENCHMARK(BM_sample_guard_check_64)->ArgName("predicted")->Arg(0)->Arg(2)->Arg(8)->Arg(16);

void BM_drive_guard_check(benchmark::State& state) {
    safety::Limits limits;
    limits.drive = {0.8, 1};
    safety::OutputGuard guard{48000, 4000, limits};
    safety::OutputSigns signs{.silent = false};
    safety::Warnings warnings;
    for (auto _ : state) {
        signs.tick += 240;
        ++signs.judged;
        ++signs.gathered;
        benchmark::DoNotOptimize(guard.check(signs, warnings));
    }
}
BENCHMARK(BM_drive_guard_check);

/// One stamp every 5.3 ms, including the fit every half second.
void BM_clock_tracker_add(benchmark::State& state) {
    calibration::ClockTracker<struct DacClock> tracker{48000};
    std::int64_t n = 0;
    for (auto _ : state) {
        const std::int64_t late = n * 2654435761 % 100'003;
        tracker.add({n * 256}, HostTime{std::chrono::nanoseconds{n * 5'333'333 + late}});
        ++n;
    }
}
BENCHMARK(BM_clock_tracker_add);

}  // namespace
}  // namespace shaker

BENCHMARK_MAIN();
