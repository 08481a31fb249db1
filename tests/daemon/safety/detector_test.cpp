// Each detector alone: its fault trips with its cause, and does not when only this detector is switched off.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "tests/support/run/virtual_run.hpp"

namespace shaker::safety {
namespace {

using test::run_virtually;
using test::VirtualRun;
using test::VirtualRunSettings;

/// A scenario in which a detector trips.
struct Scenario {
    VirtualRunSettings run;
    std::set<Cause> faster{};   // detectors that would trip earlier; switched off
    std::set<Cause> instead{};  // detectors that trip later, if this detector is off
};

// Causes other than drive and sensors, tested by RunTest, OneLiarTest and ClockGuardTest.
const std::set<Cause> of_cameras_and_clocks{Cause::tracking_lost, Cause::walker_edge, Cause::camera_missing,
                                            Cause::clock, Cause::base_motion};

const std::string bench = "[accelerometer]\naxis_told = 1\nblock_samples = 10\n";
// A run with the data sheet's response is in state run from 2 s on and at its target from 5 s on.
constexpr double running_s = 8;

/// A run with the data sheet's response and a fault in state run.
Scenario running(const std::string& fault) {
    return {.run = {.scene = bench + "[[fault]]\nat_s = 6.0137\n" + fault + "\n",
                    .periods = 200,
                    .identify = false,
                    .longest_s = running_s}};
}

Scenario running(std::function<void(Limits&)> limits) {
    return {.run = {.scene = bench, .identify = false, .limits = std::move(limits), .longest_s = running_s}};
}

const std::map<Cause, Scenario>& scenarios() {
    static const std::map<Cause, Scenario> all = [] {
        std::map<Cause, Scenario> s;
        // The base goes to 8.7 m/s^2, 0.05 m/s, 0.34 mm at 0.2 V.
        s[Cause::acceleration] = running([](Limits& l) { l.acceleration.abort = 6; });
        s[Cause::acceleration_rms] = running([](Limits& l) { l.acceleration_rms.abort = 4; });
        s[Cause::coil_heat] = running([](Limits& l) {
            l.coil_A.abort = 0.05;
            l.coil_A_per_V = 1;
            l.coil_time_s = 1;
        });
        s[Cause::velocity] = running([](Limits& l) { l.velocity.abort = 0.03; });
        s[Cause::displacement] = running([](Limits& l) { l.displacement.abort = 0.2e-3; });
        s[Cause::drive] = running([](Limits& l) { l.drive.abort = 0.1; });
        s[Cause::drive].faster = {Cause::residual};  // a drive that is cut moves the base less than predicted
        s[Cause::sensor_open] = running("what = \"open\"");
        s[Cause::sensor_open].instead = {Cause::transverse};
        s[Cause::sensor_frozen] = running("what = \"frozen\"");
        s[Cause::sensor_frozen].instead = {Cause::loop_divergence};
        s[Cause::sensor_saturated] = running("what = \"saturated\"");
        s[Cause::sensor_saturated].faster = {Cause::acceleration, Cause::acceleration_rms, Cause::residual,
                                             Cause::polarity,     Cause::sensor_open,      Cause::transverse,
                                             Cause::gravity,      Cause::sensor_frozen};
        s[Cause::sensor_saturated].instead = {Cause::velocity, Cause::displacement, Cause::loop_divergence};
        s[Cause::sensor_missing] = running("what = \"silent\"\nfor_s = 100");
        s[Cause::residual] = running("what = \"amplifier_gain\"\nvalue = 2");
        s[Cause::residual].instead = {Cause::loop_divergence};
        s[Cause::polarity] = running("what = \"flipped\"");
        s[Cause::polarity].instead = {Cause::transverse};
        s[Cause::gravity] = running("what = \"swapped\"");
        s[Cause::gravity].instead = {Cause::transverse};
        s[Cause::underrun] = running("what = \"underrun\"\nvalue = 480");
        s[Cause::loop_divergence] = running("what = \"amplifier_gain\"\nvalue = 1.8");
        s[Cause::loop_divergence].faster = {Cause::residual};
        s[Cause::loop_divergence].instead = {Cause::harmonic_band};
        s[Cause::harmonic_band] = running("what = \"amplifier_gain\"\nvalue = 1.8");
        s[Cause::harmonic_band].faster = {Cause::residual, Cause::loop_divergence};
        // Across the axis: mounted 35 degrees from the given axis.
        s[Cause::transverse] = {
            .run = {.scene = bench + "yaw_deg = 35\n", .identify = false, .longest_s = running_s}};
        s[Cause::transverse].run.stated = [](AccelerometerInfo& info) { info.shaker_axis = {1, 0, 0}; };
        s[Cause::sensor_not_finite] = {.run = {.scene = bench, .longest_s = 0.5}};
        s[Cause::sensor_not_finite].run.stated = [](AccelerometerInfo& info) {
            info.mps2_per_count[1] = NAN;
        };
        s[Cause::gain_limit] = {
            .run = {.scene = bench + "[[fault]]\nat_s = 0\nwhat = \"amplifier_gain\"\nvalue = 0.1\n"}};
        s[Cause::watchdog] = {.run = {.scene = bench,
                                      .identify = false,
                                      .stalls_at_s = 3,
                                      .stalls_for_s = 0.7,
                                      .longest_s = running_s}};
        for (const Cause asked : {Cause::operator_stop, Cause::recorder, Cause::mixer}) {
            s[asked] = {.run = {.scene = bench, .identify = false, .longest_s = running_s}};
            s[asked].run.each = [asked, stopped = false](run::Sequence& sequence,
                                                         acquisition::Channels& channels,
                                                         double now_s) mutable {
                if (now_s > 3 && !stopped) sequence.stop(channels, {.cause = asked}), stopped = true;
            };
        }
        s[Cause::abort_input] = {
            .run = {.scene = bench + "[[fault]]\nat_s = 3\nwhat = \"contact_open\"\nfor_s = 0.1\n",
                    .identify = false,
                    .longest_s = running_s}};
        return s;
    }();
    return all;
}

VirtualRun run_without(const Scenario& scenario, const std::set<Cause>& off) {
    VirtualRunSettings settings = scenario.run;
    for (const Cause c : scenario.faster) settings.detectors.reset(static_cast<std::size_t>(c));
    for (const Cause c : off) settings.detectors.reset(static_cast<std::size_t>(c));
    return run_virtually(settings);
}

class DetectorTest : public ::testing::TestWithParam<Cause> {};
class DetectorOffTest : public ::testing::TestWithParam<Cause> {};

// External causes are not detectors and cannot be switched off.
std::vector<Cause> all_but(const std::set<Cause>& not_these) {
    std::vector<Cause> of;
    for (const auto& [cause, scenario] : scenarios())
        if (!not_these.contains(cause)) of.push_back(cause);
    return of;
}

std::string cause_name(const ::testing::TestParamInfo<Cause>& from) { return name(from.param); }

TEST_P(DetectorTest, TripsByItsCause) {
    const VirtualRun run = run_without(scenarios().at(GetParam()), {});
    ASSERT_TRUE(run.trip);
    std::printf("%s\n", text(*run.trip).c_str());
    EXPECT_EQ(run.trip->cause, GetParam()) << text(*run.trip);
}

TEST_P(DetectorOffTest, NothingTripsByItsCause) {
    const Scenario& scenario = scenarios().at(GetParam());
    const VirtualRun run = run_without(scenario, {GetParam()});
    if (run.trip) std::printf("off: %s\n", text(*run.trip).c_str());
    EXPECT_EQ(run.trip.has_value(), !scenario.instead.empty()) << "what stands in for it";
    if (run.trip) {
        EXPECT_TRUE(scenario.instead.contains(run.trip->cause)) << text(*run.trip);
    }
}

INSTANTIATE_TEST_SUITE_P(All, DetectorTest, ::testing::ValuesIn(all_but({})), cause_name);
INSTANTIATE_TEST_SUITE_P(All, DetectorOffTest,
                         ::testing::ValuesIn(all_but({Cause::operator_stop, Cause::recorder,
                                                      Cause::abort_input, Cause::mixer})),
                         cause_name);

TEST(DetectorsTest, EveryDetectorHasAScenario) {
    for (std::size_t i = 0; i < causes; ++i) {
        const auto cause = static_cast<Cause>(i);
        EXPECT_NE(scenarios().contains(cause), of_cameras_and_clocks.contains(cause)) << name(cause);
    }
}

}  // namespace
}  // namespace shaker::safety
