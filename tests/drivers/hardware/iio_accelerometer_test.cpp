#include "drivers/hardware/iio/iio_accelerometer.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <optional>
#include <thread>

#include "drivers/errors.hpp"
#include "tests/drivers/hardware/iio_bench.hpp"
#include "tests/support/in_real_time.hpp"
#include "tests/support/no_alloc.hpp"

namespace shaker::hardware {
namespace {

using std::chrono::milliseconds;
using test::IioBench;
using test::settings_for;

std::string refusal(const iio::IioSettings& settings) {
    try {
        static_cast<void>(open_iio_accelerometer(settings));
    } catch (const DeviceError& e) {
        return e.what();
    }
    return "";
}

TEST(IioAccelerometerTest, ReportsPropertiesOfTheDevice) {
    const mock::Iiod iiod{{.mps2_per_count = {1e-5, 2e-5, 3e-5}, .offset_counts = {0, 5, -7}}};
    iio::IioSettings s = settings_for(iiod);
    s.rate_hz = 1000;
    s.shaker_axis = {0, 1, 0};
    s.clock_uncertainty_s = 0.003;
    const auto device = open_iio_accelerometer(s);
    const AccelerometerInfo info = device->info();
    EXPECT_NE(info.name.find("adxl355"), std::string::npos);
    EXPECT_EQ(info.rate_hz, 1000);
    EXPECT_EQ(iiod.rate_hz(), 1000);
    EXPECT_EQ(info.mps2_per_count[2], 3e-5);
    EXPECT_EQ(info.offset_counts[1], 5);
    EXPECT_EQ(info.shaker_axis[1], 1);
    EXPECT_EQ(info.clock_uncertainty_s, 0.003);
}

// The z channel of the device alone, as of a sensor with one axis and no gravity in its reading.
TEST(IioAccelerometerTest, ReadsOneAxisAlone) {
    mock::Iiod iiod{{.mps2_per_count = {1e-5, 2e-5, 3e-5}, .offset_counts = {0, 5, -7}, .fifo = 65536}};
    const test::PatternFeeder feeder{iiod, 4000};
    iio::IioSettings s = settings_for(iiod);
    s.channels = {"accel_z"};
    s.gravity = false;
    const auto device = open_iio_accelerometer(s);
    const AccelerometerInfo info = device->info();
    EXPECT_EQ(info.axes, 1);
    EXPECT_FALSE(info.gravity);
    EXPECT_EQ(info.mps2_per_count, (std::array<double, 3>{3e-5, 0, 0}));
    EXPECT_EQ(info.offset_counts, (std::array<double, 3>{-7, 0, 0}));
    EXPECT_NEAR(info.range_mps2, 3e-5 * ((1 << 19) - 8), 1e-6);
    int read = 0;
    std::optional<std::int32_t> last;
    for (int waits = 0; read < 4000 && waits < 400; ++waits) {
        AccelBlock block;
        if (!device->read(block, milliseconds{50})) continue;
        for (int i = 0; i < block.size; ++i, ++read) {
            const auto& counts = block.counts[static_cast<std::size_t>(i)];
            if (last) {  // the pattern counts down along z
                ASSERT_EQ(counts[0], *last - 1) << "sample " << read;
            }
            last = counts[0];
            ASSERT_EQ(counts[1], 0);
            ASSERT_EQ(counts[2], 0);
        }
        EXPECT_FALSE(has(block.quality, Quality::clipped));
    }
    EXPECT_GE(read, 4000);
}

TEST(IioAccelerometerTest, NamesUnavailableSettings) {
    const mock::Iiod iiod{{.serial = "77"}};
    iio::IioSettings s = settings_for(iiod);
    s.device = "bmi160";
    EXPECT_NE(refusal(s).find("no device \"bmi160\"; found adxl355"), std::string::npos) << refusal(s);
    s.device = "77";
    EXPECT_EQ(refusal(s), "");
    s.rate_hz = 1234;
    EXPECT_NE(refusal(s).find("available: 4000 2000"), std::string::npos) << refusal(s);
    s.rate_hz.reset();
    s.trigger = "sysfs";
    EXPECT_NE(refusal(s).find("no trigger \"sysfs\""), std::string::npos);
    s.trigger = "adxl355-dev0";
    EXPECT_EQ(refusal(s), "");
    s.channels[1] = "accel_w";
    EXPECT_NE(refusal(s).find("accel_w"), std::string::npos);
    s.uri = "ip:127.0.0.1:1";
    EXPECT_NE(refusal(s).find("Connection refused"), std::string::npos) << refusal(s);
}

TEST(IioAccelerometerTest, UsesGivenRateIfDeviceHasNone) {
    const mock::Iiod iiod{{.rate_hz = 0, .rates_hz = {}}};
    iio::IioSettings s = settings_for(iiod);
    EXPECT_NE(refusal(s).find("does not report its rate; set rate_hz"), std::string::npos) << refusal(s);
    s.rate_hz = 4000;
    std::vector<std::string> notes;
    EXPECT_EQ(open_iio_accelerometer(s, &notes)->info().rate_hz, 4000);
    EXPECT_TRUE(std::ranges::any_of(
        notes, [](const std::string& note) { return note.find("rate_hz is used") != note.npos; }));
}

TEST(IioAccelerometerTest, DeliversFourKilohertzWithStamps) {
    IioBench bench;
    bench.open();
    ASSERT_TRUE(bench.read_for(2));
    EXPECT_EQ(bench.reading->wrong, 0);
    EXPECT_EQ(bench.reading->gaps, 0);
    EXPECT_EQ(bench.reading->ragged, 0);
    EXPECT_EQ(bench.device->counts().lost, 0U);
    EXPECT_EQ(bench.device->counts().incidents, 0U);
    EXPECT_EQ(bench.iiod.counts().overflowed, 0U);
    for (const AccelBlock& b : bench.reading->blocks) {
        const std::int64_t n = bench.reading->first() + b.first.n + b.size - 1;
        ASSERT_EQ(b.arrived.time_since_epoch().count(), bench.feeder.first_stamp_ns() + n * 250'000);
    }
}

TEST(IioAccelerometerTest, DroppedSamplesAreCountedExactly) {
    for (const iio::IioStamps stamps : {iio::IioStamps::host, iio::IioStamps::device}) {
        IioBench bench;
        bench.open(stamps);
        ASSERT_TRUE(bench.read_for(0.5));
        for (const std::uint64_t n : {1U, 3U, 64U, 500U}) {
            bench.iiod.drop(n);
            ASSERT_TRUE(bench.read_for(n < 80 ? 0.2 : 0.6));  // a loss of over 20 ms is clear after 0.4 s
        }
        EXPECT_EQ(bench.reading->wrong, 0);
        EXPECT_EQ(bench.reading->unmarked, 0);
        EXPECT_EQ(bench.reading->gaps, 4);
        EXPECT_EQ(bench.reading->missing(), 568);
        EXPECT_EQ(bench.device->counts().lost, 568U);
        EXPECT_EQ(bench.iiod.counts().dropped, 568U);
        EXPECT_EQ(bench.device->counts().reopened, 0U);
    }
}

TEST(IioAccelerometerTest, CountsOverflowDuringSilenceExactly) {
    IioBench bench{{.fifo = 512}};
    bench.open();
    ASSERT_TRUE(bench.read_for(0.5));
    bench.iiod.silence(0.5);
    ASSERT_TRUE(bench.read_for(1.5));
    if (!test::in_real_time) return;
    EXPECT_EQ(bench.reading->wrong, 0);
    EXPECT_GT(bench.device->counts().lost, 1000U);
    EXPECT_EQ(bench.device->counts().lost, bench.iiod.counts().overflowed);
    EXPECT_EQ(bench.device->counts().incidents, 0U);
}

TEST(IioAccelerometerTest, LateStampsAreNotLosses) {
    IioBench bench;
    bench.iiod.jitter_stamps(4'600'000);
    bench.open();
    ASSERT_TRUE(bench.read_for(2));
    EXPECT_EQ(bench.device->counts().lost, 0U);
    EXPECT_EQ(bench.reading->wrong, 0);
}

TEST(IioAccelerometerTest, ClockJumpIsAnIncidentAndTimeContinues) {
    for (const std::int64_t step : {1'000'000'000LL, -3'600'000'000'000LL}) {
        IioBench bench;
        bench.open();
        ASSERT_TRUE(bench.read_for(1));
        bench.iiod.shift_stamps(step);
        ASSERT_TRUE(bench.read_for(1));
        EXPECT_EQ(bench.device->counts().lost, 0U);
        EXPECT_EQ(bench.device->counts().incidents, 1U);
        EXPECT_EQ(bench.reading->wrong, 0);
        const AccelBlock& b = bench.reading->blocks.back();
        const std::int64_t n = bench.reading->first() + b.first.n + b.size - 1;
        const std::int64_t due = bench.feeder.first_stamp_ns() + n * 250'000;
        // The step is removed with the accuracy of the last samples' deviation from the line.
        EXPECT_NEAR(static_cast<double>(b.arrived.time_since_epoch().count() - due), 0, 5000);
    }
}

TEST(IioAccelerometerTest, PassesOnFrozenSamples) {
    IioBench bench;
    bench.open();
    ASSERT_TRUE(bench.read_for(0.5));
    bench.iiod.freeze(0.1);
    ASSERT_TRUE(bench.read_for(0.5));
    EXPECT_EQ(bench.reading->wrong, 400);  // repeated counts at increasing ticks
    EXPECT_EQ(bench.device->counts().lost, 0U);
}

/// Required result of every fault that breaks the connection: counted, reconnected, correct ticks.
void expect_rebuilt(IioBench& bench, const char* fault) {
    ASSERT_TRUE(bench.read_for(1)) << fault;
    const DeviceCounts counts = bench.device->counts();
    EXPECT_EQ(bench.reading->wrong, 0) << fault;
    EXPECT_EQ(bench.reading->unmarked, 0) << fault;
    EXPECT_GE(counts.incidents, 1U) << fault;
    EXPECT_GE(counts.reopened, 1U) << fault;
    EXPECT_EQ(counts.lost, static_cast<std::uint64_t>(bench.reading->missing())) << fault;
}

TEST(IioAccelerometerTest, ReconnectsAndKeepsTicksInTime) {
    IioBench bench;
    bench.open();
    ASSERT_TRUE(bench.read_for(0.5));
    bench.iiod.disconnect();
    expect_rebuilt(bench, "disconnect");
    bench.iiod.disconnect();
    expect_rebuilt(bench, "disconnect again");
    EXPECT_GT(bench.device->counts().lost, 0U);
}

TEST(IioAccelerometerTest, CreatesNewBufferAfterServerError) {
    IioBench bench;
    bench.open();
    ASSERT_TRUE(bench.read_for(0.5));
    for (const int error : {-ETIMEDOUT, -EIO, -ENODEV, -EBADF, -EBUSY}) {
        bench.iiod.error(error);
        ASSERT_TRUE(bench.read_for(0.7)) << error;
    }
    EXPECT_EQ(bench.reading->wrong, 0);
    EXPECT_EQ(bench.device->counts().incidents, 5U);
    EXPECT_EQ(bench.device->counts().reopened, 5U);
}

TEST(IioAccelerometerTest, LeavesSilentServerAfterTimeout) {
    IioBench bench;
    bench.open(iio::IioStamps::host, 0.3);
    ASSERT_TRUE(bench.read_for(0.5));
    bench.iiod.silence(1);
    expect_rebuilt(bench, "silence");
    EXPECT_LE(bench.device->counts().incidents, 4U);
}

TEST(IioAccelerometerTest, CountsBreakByTimeWithoutStamps) {
    IioBench bench;
    bench.open(iio::IioStamps::none);
    ASSERT_TRUE(bench.read_for(0.5));
    EXPECT_EQ(bench.reading->wrong, 0);
    bench.iiod.drop(100);
    ASSERT_TRUE(bench.read_for(0.5));
    EXPECT_EQ(bench.device->counts().lost, 0U);  // unknowable
    const std::int64_t off_before = bench.reading->off_by;
    EXPECT_EQ(off_before, 100);
    bench.iiod.disconnect();
    ASSERT_TRUE(bench.read_for(0.5));
    EXPECT_GE(bench.reading->gaps, 1);
    // Accurate to the delays of the host before and after: 500 ms of stalls would be 2000 samples.
    EXPECT_LT(bench.reading->off_by, 2000);
}

TEST(IioAccelerometerTest, ReportsClockThatCannotBeSet) {
    IioBench bench{{.monotonic = false, .fifo = 65536}};
    bench.open();
    ASSERT_EQ(bench.notes.size(), 1U);
    EXPECT_NE(bench.notes[0].find("they use realtime"), std::string::npos) << bench.notes[0];
    ASSERT_TRUE(bench.read_for(0.6));
    EXPECT_EQ(bench.reading->wrong, 0);
    for (const AccelBlock& b : bench.reading->blocks) {
        const std::int64_t n = bench.reading->first() + b.first.n + b.size - 1;
        const std::int64_t late =
            b.arrived.time_since_epoch().count() - bench.feeder.first_stamp_ns() - n * 250'000;
        ASSERT_GT(late, 0);  // arrivals
    }
}

TEST(IioAccelerometerTest, SamplesAtTheEndOfTheRangeAreClipped) {
    mock::Iiod iiod{{}};
    iio::IioSettings s = settings_for(iiod);
    s.stamps = iio::IioStamps::none;
    std::vector<mock::IiodSample> samples(64);
    const auto quality = [&](std::int32_t count) {
        const auto device = open_iio_accelerometer(s);
        AccelBlock block;
        device->read(block, milliseconds{100});  // now it listens
        samples[7].counts[1] = count;
        iiod.push(samples);
        for (int i = 0; i < 100 && !device->read(block, milliseconds{50}); ++i) iiod.push(samples);
        return block.quality;
    };
    EXPECT_EQ(quality(524286), Quality::good);
    EXPECT_EQ(quality(524287), Quality::clipped);
    EXPECT_EQ(quality(-524288), Quality::clipped);
    s.range_mps2 = 10;
    EXPECT_EQ(quality(-261470), Quality::good);     // 9.9999 m/s^2
    EXPECT_EQ(quality(-261480), Quality::clipped);  // 10.0003 m/s^2
}

TEST(IioAccelerometerTest, StopEndsWaitWithoutFault) {
    mock::Iiod iiod{{}};  // never fed
    iio::IioSettings s = settings_for(iiod);
    s.timeout_s = 60;
    s.give_up_s = 60;
    const auto device = open_iio_accelerometer(s);
    std::jthread other{[&] {
        std::this_thread::sleep_for(milliseconds{100});
        device->stop();
    }};
    AccelBlock block;
    EXPECT_FALSE(device->ended());
    while (!device->ended()) EXPECT_FALSE(device->read(block, milliseconds{60'000}));
    EXPECT_EQ(device->counts().incidents, 0U);
}

TEST(IioAccelerometerTest, GivesUpSilentSensorWithItsError) {
    mock::Iiod iiod{{}};
    iio::IioSettings s = settings_for(iiod);
    s.timeout_s = 0.2;
    s.give_up_s = 1;
    const auto device = open_iio_accelerometer(s);
    AccelBlock block;
    try {
        while (!device->read(block, milliseconds{50})) {
        }
        FAIL() << "samples came";
    } catch (const DeviceError& e) {
        const std::string why = test::in_real_time ? ": Connection timed out" : "";
        EXPECT_NE(std::string{e.what()}.find("no samples for 1 s" + why), std::string::npos) << e.what();
    }
    EXPECT_GE(device->counts().incidents, 2U);
    EXPECT_LE(device->counts().incidents, 20U);  // every 0.1 s and pauses in between
}

double cpu_s() {
    timespec t{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// A streaming driver with a time-out of 1 s whose server ends.
struct Bereaved {
    std::unique_ptr<mock::Iiod> iiod = std::make_unique<mock::Iiod>(mock::IiodDescription{});
    std::uint16_t port = iiod->port();
    std::unique_ptr<Accelerometer> device;
    AccelBlock block;

    Bereaved() {
        iio::IioSettings s = settings_for(*iiod);
        s.give_up_s = 1;
        device = open_iio_accelerometer(s);
        device->read(block, milliseconds{10});
        iiod.reset();
    }
};

TEST(IioAccelerometerTest, RetriesLostServerWithoutBusyLoop) {
    Bereaved b;
    const double before = cpu_s();
    EXPECT_THROW(while (!b.device->read(b.block, milliseconds{50})){}, DeviceError);
    EXPECT_LT(cpu_s() - before, 0.5);  // of one second; a busy loop would take all of it
    EXPECT_EQ(b.device->counts().reopened, 0U);
}

TEST(IioAccelerometerTest, RejectsDifferentDeviceAfterReconnect) {
    Bereaved b;
    mock::Iiod other{{.mps2_per_count = {1, 1, 1}}, b.port};
    const test::PatternFeeder feeder{other, 4000};
    try {
        while (!b.device->read(b.block, milliseconds{50})) {
        }
        FAIL() << "its samples were taken";
    } catch (const DeviceError& e) {
        EXPECT_NE(std::string{e.what()}.find("a different scale"), std::string::npos) << e.what();
    }
}

TEST(IioAccelerometerTest, ReadDoesNotAllocateWhileRunning) {
    IioBench bench;
    bench.open();
    ASSERT_TRUE(bench.read_for(0.4));
    AccelBlock block;
    int blocks = 0;
    const test::NoAlloc guard;
    for (int i = 0; i < 200 && blocks < 20; ++i)
        blocks += bench.device->read(block, milliseconds{50}) ? 1 : 0;
    EXPECT_EQ(blocks, 20);
}

}  // namespace
}  // namespace shaker::hardware
