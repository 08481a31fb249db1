// A bench on call without a client: tasks of a drive, measurements that end early, and what was true
// meanwhile.
#include "daemon/on_call/on_call.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "daemon/recording/tables/measured_tables.hpp"
#include "drivers/errors.hpp"
#include "drivers/recorded/h5/h5.hpp"
#include "tests/support/program.hpp"
#include "tests/support/run/bench_on_call.hpp"

namespace shaker::on_call {
namespace {

/// One action, as soon as its condition holds.
struct Act {
    std::function<bool(const run::Sequence&, const OnCall&)> when;
    std::function<void(OnCall&, acquisition::Channels&)> act;
};

class OnCallTest : public testing::Test {
protected:
    OnCallTest() { std::ofstream{folder_ / "scene.toml"} << test::slow; }

    /// Plays the actions in their order and collects the measurements.
    std::vector<Measured> play(std::vector<Act> acts, double limit_s = 60) {
        run::RunOptions options = test::quick();
        options.scene = folder_ / "scene.toml";
        run::Runner runner{{.run = options, .on_call = true, .recordings = folder_}};
        OnCall bench{runner, false};
        std::vector<Measured> all;
        std::size_t next = 0;
        const auto over = [&] {
            return (next == acts.size() && bench.at_rest()) || runner.sequence().now_s() > limit_s;
        };
        runner.lead(
            [&](const acquisition::Streams& streams, acquisition::Channels& channels) {
                const bool any = bench.take(streams, channels);
                while (auto m = bench.measured()) all.push_back(std::move(*m));
                if (next < acts.size() && acts[next].when(runner.sequence(), bench))
                    acts[next++].act(bench, channels);
                bench.follow(options, channels);
                while (bench.finished()) {
                }
                return any;
            },
            over);
        EXPECT_EQ(next, acts.size()) << "in " << limit_s << " s";
        sequence_notes_ = runner.sequence().notes();
        return all;
    }
    Act begin(const Drive& drive, const run::Task& task, const std::string& name = {}) {
        return {[](const run::Sequence& s, const OnCall&) { return s.state() == run::RunState::idle; },
                [=, this](OnCall& bench, acquisition::Channels& channels) {
                    run::RunOptions run = test::quick();
                    run.drive = drive;
                    bench.begin(run, task, name.empty() ? std::filesystem::path{} : folder_ / name, {},
                                channels);
                }};
    }
    static Act set(std::function<bool(const run::Sequence&, const OnCall&)> when, const Drive& drive,
                   const run::Task& task) {
        return {std::move(when),
                [=](OnCall& bench, acquisition::Channels& channels) { bench.set(drive, task, channels); }};
    }
    static bool holding(const run::Sequence& s, const OnCall& /*bench*/) { return s.holding(); }
    Act end(std::function<bool(const run::Sequence&, const OnCall&)> when) {
        return {std::move(when), [](OnCall& bench, acquisition::Channels& channels) { bench.end(channels); }};
    }
    /// True when this many periods of the measurement under way have been driven.
    static auto measured_for(double periods) {
        return [periods](const run::Sequence& s, const OnCall&) {
            return s.measuring() && (s.now_s() - s.from_s()) * 20 >= periods;
        };
    }

    std::filesystem::path folder_ = test::fresh_folder();
    std::vector<std::string> sequence_notes_;
};

int periods(const Measured& m) {
    return static_cast<int>(std::lround((m.measurement.part.to_s - m.measurement.part.from_s) * 20));
}

TEST_F(OnCallTest, TaskEndsAfterItsMeasurementsAndDriveIsKept) {
    const auto all = play({begin({}, {.plan = {.periods = 8, .measurements = 2}}), end(holding)});
    ASSERT_EQ(all.size(), 2U);
    for (const Measured& m : all) {
        EXPECT_EQ(periods(m), 8);
        ASSERT_TRUE(m.reduction) << m.not_reduced;
        EXPECT_NEAR(m.reduction->v_D.value, m.true_v_D, 4 * m.reduction->v_D.sigma);
    }
}

TEST_F(OnCallTest, MoveMeasuresNothing) {
    bool moved = false;
    const auto all =
        play({begin({}, {.plan = {.periods = 0}}), end([&](const run::Sequence& s, const OnCall&) {
                  moved = moved || (s.holding() && s.walker().x_m() && *s.walker().x_m() > 0.01);
                  return moved;
              })});
    EXPECT_TRUE(moved) << "the walker goes its way meanwhile";
    EXPECT_TRUE(all.empty());
}

TEST_F(OnCallTest, SetPointKeepsWholePeriodsOfTheOneBefore) {
    Drive other;
    other.phi = 1.2;
    const auto all =
        play({begin({}, {.plan = {.periods = 40, .measurements = 1}}, "kept.nxs"),
              set(measured_for(13.5), other, {.plan = {.periods = 10, .measurements = 1}}), end(holding)});
    ASSERT_EQ(all.size(), 2U);
    EXPECT_GE(periods(all[0]), 10);
    EXPECT_LE(periods(all[0]), 11) << "two periods are the margin of a reduction";
    ASSERT_TRUE(all[0].reduction) << all[0].not_reduced;
    EXPECT_NEAR(all[0].reduction->v_D.value, all[0].true_v_D, 4 * all[0].reduction->v_D.sigma);
    EXPECT_EQ(all[0].measurement.asked.phi, 0);
    EXPECT_EQ(all[1].measurement.asked.phi, 1.2);
    EXPECT_EQ(periods(all[1]), 10);
    const recorded::RecordingReader file{folder_ / "kept.nxs"};
    const auto rows = recording::read_finished(file);
    ASSERT_EQ(rows.size(), 2U);
    for (std::size_t i = 0; i < 2; ++i) EXPECT_EQ(rows[i].part, all[i].measurement.part);
}

TEST_F(OnCallTest, StopKeepsWholePeriods) {
    const auto all = play({begin({}, {.plan = {.periods = 40, .measurements = 1}}), end(measured_for(20))});
    ASSERT_EQ(all.size(), 1U);
    EXPECT_GE(periods(all[0]), 17);
    EXPECT_TRUE(all[0].reduction) << all[0].not_reduced;
}

TEST_F(OnCallTest, TooFewPeriodsAreNoMeasurement) {
    EXPECT_TRUE(
        play({begin({}, {.plan = {.periods = 40, .measurements = 1}}), end(measured_for(5.5))}).empty());
}

TEST_F(OnCallTest, RecordedDriveKeepsItsFrequency) {
    Drive other;
    other.frequency = 25;
    std::string refused;
    play({begin({}, {.plan = {.periods = 8, .measurements = 1}}, "one.nxs"),
          {holding,
           [&](OnCall& bench, acquisition::Channels& channels) {
               try {
                   bench.set(other, {}, channels);
               } catch (const InputError& e) {
                   refused = e.what();
               }
           }},
          end(holding)});
    EXPECT_EQ(refused, "the frequency cannot change during a recorded run; stop the run first");
}

}  // namespace
}  // namespace shaker::on_call
