// Memory of a single run that settles for minutes before its measurement.
#include <gtest/gtest.h>
#include <malloc.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <memory>
#include <vector>

#include "daemon/commands/replay.hpp"
#include "daemon/run/runner.hpp"
#include "drivers/time.hpp"
#include "tests/support/program.hpp"

namespace shaker::run {
namespace {

// Measures the memory in use once a second of the experiment.
class WatchedDac final : public Dac {
public:
    WatchedDac(std::unique_ptr<Dac> inner, std::vector<double>& bytes)
        : inner_{std::move(inner)}, bytes_{bytes} {}
    [[nodiscard]] DacInfo info() const override { return inner_->info(); }
    PlayTime write(std::span<const double> volts, std::span<const double> trigger) override {
        const PlayTime played = inner_->write(volts, trigger);
        if (counted_s(played.tick, info().rate_hz) < static_cast<double>(bytes_.size())) return played;
        const auto heap = ::mallinfo2();
        bytes_.push_back(static_cast<double>(heap.uordblks) + static_cast<double>(heap.hblkhd));
        return played;
    }
    void stop() noexcept override { inner_->stop(); }

private:
    std::unique_ptr<Dac> inner_;
    std::vector<double>& bytes_;
};

constexpr const char* own_clocks =
    "[top]\npositions = 1\nframe_rate_hz = 50\n[side]\npositions = 1\nframe_rate_hz = 50\nown_clock = 1\n";

// Bytes per second from 60 s to 100 s of a run that settles for 100 s.
double slope_of(const std::filesystem::path& folder, const std::string& out) {
    std::ofstream{folder / "scene.toml"} << own_clocks;
    RunOptions options;
    options.scene = folder / "scene.toml";
    options.pictures = recorded::KeptPictures::off;
    options.drive.frequency = 4;
    options.drive.gamma = 0.3;   // the walker rests on the base, so that it stays in view
    options.plan.settle = 2000;  // the measurement starts after 400 periods at the latest
    options.plan.periods = 20;
    if (!out.empty()) options.out = folder / out;
    std::vector<double> bytes;
    bytes.reserve(1000);
    Runner runner{{.run = options, .recordings = folder}};
    runner.bench().rig.dac = std::make_unique<WatchedDac>(std::move(runner.bench().rig.dac), bytes);
    const FinishedRun run = runner.run();
    EXPECT_TRUE(run.results.reduction) << run.results.not_reduced;
    EXPECT_GT(run.results.part.from_s, 100);
    const double slope = bytes.size() > 100 ? (bytes[100] - bytes[60]) / 40 : NAN;
    std::printf("memory slope: %.2f kB/s\n", 1e-3 * slope);
    return slope;
}

TEST(LongSettlingTest, MemoryStaysFlatWithoutRecording) {
    if (SHAKER_SANITIZED) GTEST_SKIP() << "a sanitiser keeps what was freed";
    EXPECT_LT(slope_of(test::fresh_folder(), ""), 10e3) << "bytes per second";
}

TEST(LongSettlingTest, MemoryStaysFlatAndReplayIsIdentical) {
    if (SHAKER_SANITIZED) GTEST_SKIP() << "a sanitiser keeps what was freed";
    const auto folder = test::fresh_folder();
    // Besides, the stamps of 50 frames a second and the simulated truth of 100, 32 bytes each, in lists that
    // double.
    EXPECT_LT(slope_of(folder, "run.nxs"), 10e3 + 2 * 150 * 32) << "bytes per second";
    EXPECT_TRUE(commands::replay({.file = folder / "run.nxs"}));
}

}  // namespace
}  // namespace shaker::run
