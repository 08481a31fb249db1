// Devices and threads that fail while the shaker is driven: the drive ends with a ramp, or goes on where its
// guards need nothing of the failed device.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

#include "tests/support/run/bench_on_call.hpp"

namespace shaker::service {
namespace {

using run::RunState;
using test::Answers;
using test::from_s;
using test::in;
using test::slow;
using test::until;

class FailedDeviceTest : public test::OnCallBench {
protected:
    FailedDeviceTest() { options.drive.phi = 1.75; }  // a slow walk
};

std::string gone(const char* camera, double at_s) {
    return test::fault("camera_gone", at_s, "camera = \"" + std::string{camera} + "\"\n");
}

TEST_F(FailedDeviceTest, RunGoesOnWithTheOtherCamera) {
    for (const char* camera : {"top", "side"}) {
        const auto r =
            play(slow + gone(camera, 9), {start(), {from_s(14), give(End{})}, until(in(RunState::idle))});
        EXPECT_EQ(answers, Answers(2, "")) << camera;
        EXPECT_EQ(r.last.trips, 0U) << camera;
        EXPECT_GT(r.last.measured_from_s, 10) << camera << ": still measured";
        const auto note = std::ranges::find_if(r.events, [&](const BenchEvent& e) {
            return e.text.find("camera \"" + std::string{camera} + "\" has failed") != std::string::npos;
        });
        EXPECT_NE(note, r.events.end());
    }
}

TEST_F(FailedDeviceTest, LossOfEveryViewOfTheWalkerStopsSoftly) {
    const auto r = play(slow + gone("top", 9) + gone("side", 10), {start(), until(in(RunState::tripped))});
    ASSERT_TRUE(r.last.trip);
    EXPECT_EQ(r.last.trip->cause, safety::Cause::camera_missing);
    EXPECT_EQ(r.last.trip->stop, safety::StopKind::soft);
    EXPECT_NEAR(static_cast<double>(r.last.trip->tick) / r.last.facts->dac.rate_hz, 10, 0.1);
}

TEST_F(FailedDeviceTest, HeldBackSamplesTripInTime) {
    const auto r =
        play(slow + test::fault("held_back", 9, "for_s = 1\n"), {start(), until(in(RunState::tripped))});
    ASSERT_TRUE(r.last.trip);
    EXPECT_EQ(r.last.trip->cause, safety::Cause::sensor_missing);
    EXPECT_LT(static_cast<double>(r.last.trip->tick) / r.last.facts->dac.rate_hz, 9.16);
}

// As behind a link that carries 88 % of the rate. The stamps are right, the samples come seconds late.
TEST_F(FailedDeviceTest, SamplesThatComeLaterAndLaterTripInTime) {
    const auto r =
        play(slow + test::fault("late", 9, "value = 0.12\n"), {start(), until(in(RunState::tripped))});
    ASSERT_TRUE(r.last.trip);
    EXPECT_EQ(r.last.trip->cause, safety::Cause::sensor_missing);
    const double tripped_s = static_cast<double>(r.last.trip->tick) / r.last.facts->dac.rate_hz;
    EXPECT_NEAR(0.12 * (tripped_s - 9), 0.02 + safety::OutputGuard::held_back_s, 0.02);
}

TEST_F(FailedDeviceTest, ThreadThatThrowsEndsTheDriveWithARamp) {
    std::ofstream{folder / "scene.toml"} << slow;
    options.scene = folder / "scene.toml";
    run::Runner runner{{.run = options, .on_call = true, .recordings = folder}};
    BenchPort port;
    BenchService session{runner, {}, port};
    bool begun = false;
    try {
        runner.lead(
            [&](const acquisition::Streams& streams, acquisition::Channels& channels) {
                const bool any = session.step(streams, channels);
                const RunState state = port.state()->state;
                if (state == RunState::idle && !begun) {
                    begun = true;
                    port.order({Begin{10}, {}});
                }
                if (state == RunState::run) throw std::runtime_error{"a defect"};
                return any;
            },
            [] { return false; });
        FAIL() << "nothing was thrown";
    } catch (const std::runtime_error& e) {
        EXPECT_STREQ(e.what(), "a defect");
    }
    const acquisition::Streams& streams = runner.collector().streams();
    ASSERT_EQ(streams.trips.size(), 1U);
    EXPECT_EQ(streams.trips[0].cause, safety::Cause::watchdog);
    EXPECT_GT(streams.changes.back().stop, 0) << "the drive ended with the ramp of a stop";
    EXPECT_GT(streams.played.back().tick.n, streams.changes.back().end().n) << "and the ramp was played";
}

}  // namespace
}  // namespace shaker::service
