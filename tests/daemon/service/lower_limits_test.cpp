// Each limit that an operator lowers below the present value stops the drive in its promised time.
#include <gtest/gtest.h>

#include <functional>

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
    std::function<void(Limits&)> lower;
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
                              Limits limits = port.state()->limits;
                              l.lower(limits);
                              ordered_s = port.state()->now_s;
                              give(LowerLimits{limits})(port);
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

INSTANTIATE_TEST_SUITE_P(EveryKey, LowerLimitsTest,
                         testing::Values(Lowered{"acceleration_rms", Cause::acceleration_rms, half_period,
                                                 [](Limits& l) {
                                                     l.acceleration_rms = {1, 2};
                                                 }},
                                         Lowered{"coil", Cause::coil_heat, half_period,
                                                 [](Limits& l) {
                                                     l.coil_A = {0.001, 0.002};
                                                 }},
                                         Lowered{"acceleration", Cause::acceleration, half_period,
                                                 [](Limits& l) {
                                                     l.acceleration = {1, 2};
                                                 }},
                                         Lowered{"velocity", Cause::velocity, half_period,
                                                 [](Limits& l) {
                                                     l.velocity = {0.005, 0.01};
                                                 }},
                                         Lowered{"displacement", Cause::displacement, half_period,
                                                 [](Limits& l) {
                                                     l.displacement = {2e-5, 5e-5};
                                                 }},
                                         Lowered{"drive", Cause::drive, half_period,
                                                 [](Limits& l) {
                                                     l.drive = {0.002, 0.004};
                                                 }},
                                         Lowered{"transverse", Cause::transverse, 0.2,
                                                 [](Limits& l) {
                                                     l.transverse = {1e-6, 1e-5};
                                                 }},
                                         Lowered{"edge", Cause::walker_edge, 0.1,
                                                 [](Limits& l) { l.edge_mm = 1000; }}),
                         [](const auto& lowered) { return std::string{lowered.param.key}; });

}  // namespace
}  // namespace shaker::service
