// Every fault of the mock bench in the middle of a run: required end of the run, equal counts on both sides.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <csignal>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "tests/support/in_real_time.hpp"
#include "tests/support/run/bench_run.hpp"

namespace shaker::test {
namespace {

// A slow walker, which does not reach the edge even if settling takes long.
constexpr const char* options = "--gamma 0.7g --phi 100deg --periods 40 --no-identify";
// Time of the fault: the drive has settled 2.5 s after the start, and the measurement of 2 s starts then.
constexpr double measuring_s = 3;

struct FaultTest : testing::Test {
    BenchRun run;

    void SetUp() override { begin(); }
    void begin() {
        if (!in_real_time) GTEST_SKIP() << "not in real time under a sanitiser";
        run.start(options);
        ASSERT_TRUE(run.played(measuring_s)) << end_of(run.finish().err);
    }
    /// The run ended normally, and v_D is within 1 % of the truth, because ticks keep their place in time.
    nlohmann::json good_results() {
        nlohmann::json r = run.results();
        if (r.empty()) return r;
        const double v_true = run.bench.drift(1, r.at("from_s"), r.at("to_s"), r.at("frequency_hz"));
        EXPECT_NEAR(r.at("v_D_mps").get<double>() / v_true, 1, 0.01);
        return r;
    }
    void expect_trip(const char* cause) {
        const Outcome o = run.finish();
        EXPECT_EQ(o.status, 5) << o.out;
        EXPECT_NE(o.err.find(cause), std::string::npos) << end_of(o.err);
    }
};

/// A long measurement, of which two seconds or more are over when the fault comes.
struct LongFaultTest : testing::Test {
    BenchRun run;

    void SetUp() override {
        if (!in_real_time) GTEST_SKIP() << "not in real time under a sanitiser";
        run.start("--gamma 0.7g --phi 100deg --periods 400 --no-identify");
        ASSERT_TRUE(run.played(measuring_s + 4)) << end_of(run.finish().err);
    }
    /// The run printed results of what it had measured before a device failed.
    void expect_partial_results(const Outcome& o) {
        EXPECT_EQ(o.status, 3);
        const auto r = nlohmann::json::parse(o.out, nullptr, false);
        ASSERT_TRUE(r.contains("v_D_mps")) << o.out << end_of(o.err);
        EXPECT_TRUE(noted(r, "a failed device stopped the run")) << r.at("notes");
        const double v_true = run.bench.drift(1, r.at("from_s"), r.at("to_s"), r.at("frequency_hz"));
        EXPECT_NEAR(r.at("v_D_mps").get<double>() / v_true, 1, 0.02);
    }
};

TEST_F(LongFaultTest, ResultsBeforeDacWasUnpluggedArePrinted) {
    run.bench.dac().unplug();
    expect_partial_results(run.finish());
}

/// Settings with which the drive continues while the accelerometer is silent.
struct PatientFaultTest : FaultTest {
    void SetUp() override {
        run.rig("missing_s", "10");
        begin();
    }
};

TEST_F(FaultTest, UnderrunIsCountedAndDriveRestartsFromSilence) {
    run.bench.dac().cause_underrun();
    const nlohmann::json r = good_results();
    ASSERT_FALSE(r.empty());
    EXPECT_EQ(run.bench.dac().counts().underruns, 1U);
    EXPECT_EQ(device(r, "shaker_mock").at("incidents"), 1);
    EXPECT_GT(device(r, "shaker_mock").at("lost"), 0);
    EXPECT_EQ(run.bench.dac().counts().streams, 2U);
    EXPECT_TRUE(noted(r, "the DAC ran empty at")) << r.at("notes");
}

TEST_F(FaultTest, StalledDacIsCountedAndRestarted) {
    run.bench.dac().stall(Seconds{1});
    const nlohmann::json r = good_results();
    ASSERT_FALSE(r.empty());
    EXPECT_GE(device(r, "shaker_mock").at("incidents"), 1);
    EXPECT_TRUE(noted(r, "the DAC ran empty at")) << r.at("notes");
}

TEST_F(FaultTest, AnUnpluggedDacEndsTheRunByName) {
    run.bench.dac().unplug();
    const Outcome o = run.finish();
    EXPECT_EQ(o.status, 3);
    EXPECT_NE(o.err.find("shaker_mock"), std::string::npos) << end_of(o.err);
    EXPECT_NE(o.err.find("No such device"), std::string::npos) << end_of(o.err);
}

TEST_F(FaultTest, LostSamplesAreCountedExactly) {
    run.bench.accelerometer().drop(60);
    const nlohmann::json r = good_results();
    ASSERT_FALSE(r.empty());
    EXPECT_EQ(run.bench.accelerometer().counts().dropped, 60U);
    EXPECT_EQ(device(r, "adxl355").at("lost"), 60);
}

// The place of the samples after a loss of more than 20 ms is known 0.4 s later only. Until then the motion
// is not compared with its prediction.
TEST_F(FaultTest, LongLossOfSamplesStopsTheDrive) {
    run.bench.accelerometer().drop(200);
    expect_trip("sensor_missing");
}

TEST_F(FaultTest, ASilentAccelerometerStopsTheDrive) {
    run.bench.accelerometer().silence(0.6);
    expect_trip("sensor_missing");
}

TEST_F(PatientFaultTest, WaitsForSilentAccelerometerWithoutLoss) {
    run.bench.accelerometer().silence(0.6);
    const nlohmann::json r = good_results();
    ASSERT_FALSE(r.empty());
    EXPECT_EQ(device(r, "adxl355").at("lost").get<std::uint64_t>(),
              run.bench.accelerometer().counts().overflowed);
}

TEST_F(FaultTest, AFrozenAccelerometerStopsTheDrive) {
    run.bench.accelerometer().freeze(2);
    expect_trip("sensor_frozen");
}

TEST_F(PatientFaultTest, BrokenSensorConnectionIsReopened) {
    run.bench.accelerometer().disconnect();
    const nlohmann::json r = good_results();
    ASSERT_FALSE(r.empty());
    EXPECT_EQ(device(r, "adxl355").at("reopened"), 1);
    const mock::IiodCounts c = run.bench.accelerometer().counts();
    EXPECT_LE(device(r, "adxl355").at("lost").get<std::uint64_t>(), c.unread + c.overflowed + c.unheard);
}

TEST_F(PatientFaultTest, BufferErrorRecreatesBuffer) {
    run.bench.accelerometer().error(-110);
    const nlohmann::json r = good_results();
    ASSERT_FALSE(r.empty());
    EXPECT_GE(device(r, "adxl355").at("incidents"), 1);
    EXPECT_GE(device(r, "adxl355").at("reopened"), 1);
}

TEST_F(FaultTest, UnsentPicturesAreCountedExactly) {
    run.bench.camera("top").drop(17);
    const nlohmann::json r = good_results();
    ASSERT_FALSE(r.empty());
    EXPECT_EQ(device(r, "\"top\"").at("lost"), 17);
    EXPECT_EQ(device(r, "\"side\"").at("lost"), 0);
}

TEST_F(FaultTest, LostPacketsLoseOnlyTheirPictures) {
    run.bench.camera("side").lose(0.01);
    run.played(measuring_s + 1);
    run.bench.camera("side").lose(0);
    const nlohmann::json r = good_results();
    ASSERT_FALSE(r.empty());
    EXPECT_GT(run.bench.camera("side").counts().damaged, 0U);
    EXPECT_EQ(device(r, "\"side\"").at("lost").get<std::uint64_t>(),
              run.bench.camera("side").counts().damaged + run.bench.camera("side").counts().overflow);
}

TEST_F(FaultTest, StalledCameraIsLateAndLosesNothing) {
    run.bench.camera("top").stall(0.5);
    const nlohmann::json r = good_results();
    ASSERT_FALSE(r.empty());
    EXPECT_EQ(device(r, "\"top\"").at("lost").get<std::uint64_t>(),
              run.bench.camera("top").counts().overflow);
}

TEST_F(FaultTest, WrongCameraStampsStartNewEpoch) {
    run.bench.camera("top").shift_stamps(753'300'000);
    const nlohmann::json r = good_results();
    ASSERT_FALSE(r.empty());
    EXPECT_TRUE(noted(r, "its time stamps jumped")) << r.at("notes");
}

TEST_F(FaultTest, UnpluggedCameraReconnects) {
    run.bench.camera("side").unplug();
    run.played(measuring_s + 0.5);
    run.bench.camera("side").plug();
    const nlohmann::json r = good_results();
    ASSERT_FALSE(r.empty());
    EXPECT_GE(device(r, "\"side\"").at("incidents"), 1);
}

TEST_F(PatientFaultTest, JumpOfSensorStampsIsIncident) {
    run.bench.accelerometer().shift_stamps(-300'000'000);
    const nlohmann::json r = good_results();
    ASSERT_FALSE(r.empty());
    EXPECT_GE(device(r, "adxl355").at("incidents"), 1);
}

TEST(CheckFaultTest, ADacThatRunsEmptyInTheSelfTestIsAFinding) {
    BenchRun run;
    Program check{"shakerd", "check --rig '" + run.bench.rig_file().string() + "'", run.folder};
    while (run.bench.dac().counts().frames < 48000 && !check.ended())
        std::this_thread::sleep_for(std::chrono::milliseconds{2});
    run.bench.dac().cause_underrun();
    const Outcome o = check.wait(60);
    if (!in_real_time) return expect_order(o);
    EXPECT_EQ(o.status, 3) << o.out << end_of(o.err);
    EXPECT_NE(o.out.find("BAD  self-test: the DAC ran empty"), std::string::npos) << o.out;
}

// After a permanent fault the run fails in bounded time, without busy waiting. A busy loop would use a whole
// processor; the program in operation uses a fifth of one.
constexpr double most_cpu = 0.6;

TEST_F(PatientFaultTest, SilentAccelerometerEndsRunWithoutBusyWaiting) {
    run.bench.accelerometer().silence(60);
    const Outcome o = run.finish();
    EXPECT_EQ(o.status, 3) << o.out;
    EXPECT_NE(o.err.find("adxl355"), std::string::npos) << end_of(o.err);
    const auto played_s = static_cast<double>(run.bench.dac().counts().frames) / 48000;
    EXPECT_GT(played_s, measuring_s + 4) << "5 s of patience";
    EXPECT_LT(o.cpu_s / played_s, most_cpu);
}

TEST_F(FaultTest, DeadDacEndsRunWithoutBusyWaiting) {
    const auto before = run.bench.dac().taken();
    run.bench.dac().stall(Seconds{60});
    const Outcome o = run.finish();
    // The fourth underrun is a trip, unless the driver gives the device up before that.
    const bool given_up = o.err.find("no playback after it was opened again") != std::string::npos;
    EXPECT_EQ(o.status, given_up ? 3 : 5) << o.out;
    EXPECT_TRUE(given_up || o.err.find("the DAC ran empty 4 times") != std::string::npos) << end_of(o.err);
    const auto waited_s = static_cast<double>(run.bench.dac().taken() - before) / 48000;
    EXPECT_LT(o.cpu_s / (measuring_s + waited_s), most_cpu);
}

TEST_F(FaultTest, KilledRunIsSilentWithinBuffer) {
    for (;;) {  // SIGKILL comes at any point of its work
        ::kill(run.program().pid(), SIGKILL);
        if (run.program().ended()) break;
    }
    const auto killed = run.bench.dac().taken();
    const Outcome o = run.finish();
    EXPECT_EQ(o.status, 128 + SIGKILL);
    constexpr std::int64_t buffer = 9600, allowed = 480;  // 10 ms
    while (run.bench.dac().taken() < killed + 2 * buffer)
        std::this_thread::sleep_for(std::chrono::milliseconds{5});
    std::ifstream in{run.folder / "codes", std::ios::binary};
    in.seekg(8 * (killed + buffer + allowed));
    std::array<std::int32_t, 2> pair{};
    std::int64_t after = 0, sounding = 0;
    for (; in.read(reinterpret_cast<char*>(pair.data()), sizeof pair); ++after)
        sounding += pair[0] != 0 ? 1 : 0;
    EXPECT_GT(after, 4800);
    EXPECT_EQ(sounding, 0);
}

}  // namespace
}  // namespace shaker::test
