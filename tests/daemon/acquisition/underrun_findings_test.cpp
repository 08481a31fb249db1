// Findings of the guards while the DAC was empty. The ones that the silence causes do not stop the drive.
#include <gtest/gtest.h>

#include <utility>

#include "daemon/acquisition/drive_output.hpp"

namespace shaker::acquisition {
namespace {

using safety::Cause;
using safety::StopKind;

constexpr std::int64_t block = 240;

/// Stands still while a block is written, like a converter that does not play.
class StallingDac final : public Dac {
public:
    [[nodiscard]] DacInfo info() const override { return {"stalling", 48000, 1}; }
    PlayTime write(std::span<const double> volts, std::span<const double>) override {
        end += std::ssize(volts) + lost;
        return {{end}, {}, std::exchange(lost, 0), std::exchange(unheard, 0)};
    }
    void stop() noexcept override {}
    std::int64_t end = 0, lost = 0, unheard = 0;  // of the next block
};

struct UnderrunFindingsTest : testing::Test {
    StallingDac dac;
    Channels channels{0};
    DriveOutput output{dac.info(), 20, 1000, block};

    void go(int blocks) {
        for (int i = 0; i < blocks; ++i) output_step(output, dac, channels);
    }
    /// One block of which nothing is heard, and `unheard` samples before its end were queued and not played.
    void stall(std::int64_t lost, std::int64_t unheard) {
        dac.lost = lost;
        dac.unheard = unheard;
        go(1);
    }
    bool stops(Cause cause, StopKind stop, std::int64_t tick) {
        EXPECT_TRUE(
            channels.ordered.push({.cause = cause, .stop = stop, .on_dac_clock = true, .tick = tick}));
        go(1);
        return channels.stopped;
    }
};

TEST_F(UnderrunFindingsTest, FindingsOfSilenceDoNotStop) {
    go(100);
    const std::int64_t before = output.synthesiser.tick().n;
    stall(9600, 4800);
    std::uint64_t excused = 0;
    for (const Cause cause : {Cause::sensor_open, Cause::residual, Cause::polarity, Cause::loop_divergence,
                              Cause::harmonic_band}) {
        EXPECT_FALSE(stops(cause, StopKind::soft, before - 4500)) << name(cause);
        EXPECT_EQ(channels.excused, ++excused);
    }
}

TEST_F(UnderrunFindingsTest, FindingBeforeSilenceStops) {
    go(100);
    const std::int64_t before = output.synthesiser.tick().n;
    stall(9600, 4800);
    EXPECT_TRUE(stops(Cause::sensor_open, StopKind::soft, before + block - 4801));
    EXPECT_EQ(channels.excused, 0U);
}

TEST_F(UnderrunFindingsTest, FindingAfterSilenceStops) {
    go(100);
    stall(9600, 4800);
    EXPECT_TRUE(stops(Cause::sensor_open, StopKind::soft, output.synthesiser.tick().n));
}

TEST_F(UnderrunFindingsTest, OtherCausesInSilenceStop) {
    for (const auto& [cause, stop] :
         {std::pair{Cause::sensor_open, StopKind::hard}, std::pair{Cause::acceleration, StopKind::hard},
          std::pair{Cause::walker_edge, StopKind::soft}, std::pair{Cause::operator_stop, StopKind::hard}}) {
        Channels other{0};
        DriveOutput fresh{dac.info(), 20, 1000, block};
        const auto step = [&] { output_step(fresh, dac, other); };
        for (int i = 0; i < 100; ++i) step();
        const std::int64_t before = fresh.synthesiser.tick().n;
        dac.lost = 9600;
        step();
        ASSERT_TRUE(other.ordered.push({.cause = cause, .stop = stop, .on_dac_clock = true, .tick = before}));
        step();
        EXPECT_TRUE(other.stopped) << name(cause);
    }
}

TEST_F(UnderrunFindingsTest, BlocksInARowAreOneSilence) {
    go(100);
    const std::int64_t before = output.synthesiser.tick().n;
    for (int i = 0; i < 3; ++i) stall(9600, 0);
    EXPECT_FALSE(stops(Cause::sensor_open, StopKind::soft, before));
    go(1);
    stall(9600, 0);
    EXPECT_TRUE(stops(Cause::sensor_open, StopKind::soft, before)) << "a new silence";
}

}  // namespace
}  // namespace shaker::acquisition
