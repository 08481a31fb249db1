// Each limit that an operator lowers below the present value stops the drive in its promised time.
#include <gtest/gtest.h>

#include "tests/support/run/bench_on_call.hpp"

namespace shaker::service {
namespace {

using run::RunState;
using safety::Cause;
using safety::Limits;

struct Lowered {
    const char* key;
    Cause cause;
    double within_s;  // LIMITS.md: from the order to the trip
    LowerLimit order;
};

void PrintTo(const Lowered& l, std::ostream* out) { *out << l.key; }

class LowerLimitsTest : public test::OnCallBench, public testing::WithParamInterface<Lowered> {};

TEST_P(LowerLimitsTest, LimitBelowPresentValueTripsInTime) {
    const Lowered& l = GetParam();
    double ordered_s = NAN;
    const auto r = play(test::slow,
                        {start(),
                         {test::measured(1),
                          [&](BenchPort& port) {
                              ordered_s = port.state()->now_s;
                              give(l.order)(port);
                          }},
                         test::until(test::in(RunState::tripped))},
                        40);
    EXPECT_EQ(answers, test::Answers(2, ""));
    ASSERT_TRUE(r.last.trip);
    EXPECT_EQ(r.last.trip->cause, l.cause) << text(*r.last.trip);
    const double tripped_s = static_cast<double>(r.last.trip->tick) / r.last.facts->dac.rate_hz;
    EXPECT_LT(tripped_s - ordered_s, l.within_s);
}

// Half a period of 50 ms until the next peak, a block of 5 ms and the blocks of the sensor.
constexpr double half_period = 0.025 + 0.02;

INSTANTIATE_TEST_SUITE_P(
    EveryKey, LowerLimitsTest,
    testing::Values(
        Lowered{"acceleration_rms", Cause::acceleration_rms, half_period, {{&Limits::acceleration_rms}, 2}},
        Lowered{"coil", Cause::coil_heat, half_period, {{&Limits::coil_A}, 0.002}},
        Lowered{"acceleration", Cause::acceleration, half_period, {{&Limits::acceleration}, 2}},
        Lowered{"velocity", Cause::velocity, half_period, {{&Limits::velocity}, 0.01}},
        Lowered{"displacement", Cause::displacement, half_period, {{&Limits::displacement}, 5e-5}},
        Lowered{"drive", Cause::drive, half_period, {{&Limits::drive}, 0.004}},
        Lowered{"transverse", Cause::transverse, 0.2, {{&Limits::transverse}, 1e-5}},
        Lowered{"edge", Cause::walker_edge, 0.1, {{}, 1000}}),
    [](const auto& lowered) { return std::string{lowered.param.key}; });

class OneLimitTest : public test::OnCallBench {
protected:
    /// An order by a client that has seen the state before the reload.
    [[nodiscard]] static std::function<void(BenchPort&)> reload(Limits limits) {
        return [limits](BenchPort& port) {
            const auto now = port.state();
            port.order({Adopt{now->wanted, now->plan, limits}, {}});
        };
    }
    [[nodiscard]] Limits limits_of_file() {
        return play(test::slow, {test::until(test::in(RunState::idle))}).last.limits;
    }
};

// Each of these keys was looser in the file before, so an order that carried all of them would loosen it.
TEST_F(OneLimitTest, OrderKeepsWhatReloadHasChanged) {
    const Limits file = limits_of_file();
    Limits reloaded = file;
    reloaded.acceleration = {30, 40};
    reloaded.camera_missing_s = 0.3;
    reloaded.missing_s = file.missing_s / 2;
    reloaded.watchdog_s = file.watchdog_s / 2;
    reloaded.tracking_lost_frames = file.tracking_lost_frames / 2;
    reloaded.coil_A_per_V = 2 * file.coil_A_per_V;
    const auto r = play(test::slow, {{test::in(RunState::idle),
                                      [&](BenchPort& port) {
                                          reload(reloaded)(port);
                                          give(LowerLimit{{&Limits::velocity}, 0.5})(port);
                                      }},
                                     test::until(test::in(RunState::idle))});
    EXPECT_EQ(answers, test::Answers{""});
    reloaded.velocity.abort = 0.5;
    reloaded.velocity.warn = std::min(0.5, file.velocity.warn);
    EXPECT_EQ(r.last.limits, reloaded);
}

TEST_F(OneLimitTest, ReloadKeepsLoweredLimitOfUnchangedKey) {
    Limits reloaded = limits_of_file();
    reloaded.acceleration.abort *= 1.1;
    const auto r = play(test::slow, {{test::in(RunState::idle), give(LowerLimit{{&Limits::velocity}, 0.5})},
                                     {test::in(RunState::idle), give(LowerLimit{{}, 12})},
                                     {test::in(RunState::idle), reload(reloaded)},
                                     test::until(test::in(RunState::idle))});
    EXPECT_EQ(answers, test::Answers(2, ""));
    EXPECT_EQ(r.last.limits.velocity.abort, 0.5);
    EXPECT_EQ(r.last.limits.edge_mm, 12);
    EXPECT_EQ(r.last.limits.acceleration, reloaded.acceleration);
}

TEST_F(OneLimitTest, NoOrderLoosensAnyLimit) {
    const Limits file = limits_of_file();
    std::vector<test::Move> moves;
    for (auto level : {&Limits::acceleration, &Limits::acceleration_rms, &Limits::coil_A, &Limits::velocity,
                       &Limits::displacement, &Limits::drive, &Limits::transverse})
        for (auto end : {&safety::Level::warn, &safety::Level::abort})
            for (const double value : {1.01 * (file.*level).*end, 1e300, double{NAN}})
                moves.push_back({test::in(RunState::idle), give(LowerLimit{{level, end}, value})});
    for (const double mm : {0.99 * file.edge_mm, -1.0, double{NAN}})
        moves.push_back({test::in(RunState::idle), give(LowerLimit{{}, mm})});
    moves.push_back(test::until(test::in(RunState::idle)));
    const auto r = play(test::slow, moves);
    EXPECT_EQ(r.last.limits, file);
    ASSERT_EQ(answers.size(), moves.size() - 1);
    for (const std::string& refused : answers)
        EXPECT_NE(refused.find("only the settings file can loosen limits"), std::string::npos) << refused;
}

}  // namespace
}  // namespace shaker::service
