#include "daemon/recording/tables/trip_table.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "daemon/run/ended_run.hpp"
#include "drivers/recorded/h5/h5.hpp"
#include "tests/support/recording/small_recording.hpp"

namespace shaker::recording {

using namespace test;
namespace {

using test::expect_in;
using test::SessionFolder;

const std::vector<RecordedTrip> two{
    {{.cause = safety::Cause::polarity,
      .stop = safety::StopKind::hard,
      .harmonic = 2,
      .value = -0.9,
      .limit = 0.3,
      .tick = 7719},
     "run",
     1.9331},
    {{.cause = safety::Cause::drive, .on_dac_clock = true, .value = 0.97, .limit = 0.95, .tick = 100000},
     "tripped",
     NAN}};

recorded::RecordingHeader header() {
    recorded::RecordingHeader h = test::small_header();
    h.groups = trip_places();
    return h;
}

class TripRecordTest : public ::testing::Test {
protected:
    TripRecordTest() {
        recorded::RecordingWriter writer{file_, header()};
        write_trips(writer, two);
        writer.close();
    }
    // The refusal of the file after a change of its group "trips".
    std::string refusal(const std::function<void(hid_t trips)>& change) {
        {
            const h5::Handle file{H5Fopen(file_.c_str(), H5F_ACC_RDWR, H5P_DEFAULT), "file"};
            change(h5::open_group(file.get(), "entry/trips").get());
        }
        return test::refusal([&] { read_trips(recorded::RecordingReader{file_}); });
    }
    SessionFolder folder_;
    std::filesystem::path file_ = folder_ / "trip.nxs";
};

TEST_F(TripRecordTest, CauseValueLimitTimeAndStateAreReadBack) {
    const std::vector<RecordedTrip> read = read_trips(recorded::RecordingReader{file_});
    ASSERT_EQ(read.size(), two.size());
    for (std::size_t i = 0; i < two.size(); ++i) {
        EXPECT_EQ(text(read[i]), text(two[i]));
        EXPECT_EQ(read[i].trip.cause, two[i].trip.cause);
        EXPECT_EQ(read[i].trip.stop, two[i].trip.stop);
        EXPECT_EQ(read[i].trip.on_dac_clock, two[i].trip.on_dac_clock);
        EXPECT_EQ(read[i].trip.harmonic, two[i].trip.harmonic);
        EXPECT_EQ(read[i].trip.value, two[i].trip.value);
        EXPECT_EQ(read[i].trip.limit, two[i].trip.limit);
        EXPECT_EQ(read[i].trip.tick, two[i].trip.tick);
        EXPECT_EQ(read[i].state, two[i].state);
    }
    EXPECT_EQ(read[0].at_s, two[0].at_s);
    EXPECT_TRUE(std::isnan(read[1].at_s));
}

TEST_F(TripRecordTest, RunWithoutStopHasNoTrips) {
    { recorded::RecordingWriter{folder_ / "well.nxs", header()}.close(); }
    EXPECT_TRUE(read_trips(recorded::RecordingReader{folder_ / "well.nxs"}).empty());
}

TEST_F(TripRecordTest, MalformedTableIsReportedByName) {
    const auto replace = [](const char* name, const std::vector<std::string>& texts) {
        return [=](hid_t trips) {
            h5::check(H5Ldelete(trips, name, H5P_DEFAULT), name);
            h5::write_texts(trips, name, texts);
        };
    };
    expect_in(refusal(replace("stop", {"soft"})), {"trips/stop", "1 rows", "2"});
    expect_in(refusal(replace("stop", {"soft", "medium"})), {"trips/stop", "medium"});
    expect_in(refusal(replace("stop", {"hard", "soft"})), {"accepted"});
    expect_in(refusal(replace("cause", {"polarity", "boredom"})), {"trips/cause", "boredom"});
    expect_in(refusal(replace("cause", {"polarity"})), {"trips/stop", "2 rows", "1"});
    expect_in(refusal([](hid_t trips) { H5Ldelete(trips, "cause", H5P_DEFAULT); }), {"trips/cause"});
}

TEST_F(TripRecordTest, InvalidTicksAndLengthsAreReported) {
    const auto replace = [](const char* name, const std::vector<double>& values) {
        return [=](hid_t trips) {
            h5::check(H5Ldelete(trips, name, H5P_DEFAULT), name);
            h5::write<double>(trips, name, values, {values.size()}, "1");
        };
    };
    expect_in(refusal(replace("tick", {1, 2.5})), {"trips/tick", "2.5"});
    expect_in(refusal(replace("tick", {1, NAN})), {"trips/tick"});
    expect_in(refusal(replace("tick", {1, 2})), {"accepted"});
    expect_in(refusal(replace("harmonic", {1e12, 2})), {"trips/harmonic"});
    expect_in(refusal(replace("harmonic", {1, 2})), {"accepted"});
    expect_in(refusal(replace("value", {1, 2, 3})), {"trips/value", "3 rows"});
}

// 10 s of a run: DAC at 48 kHz, accelerometer at 4 kHz, both clocks exact.
acquisition::Streams long_streams() {
    acquisition::Streams streams;
    streams.dac_rate_hz = 48000;
    streams.accelerometer.rate_hz = 4000;
    streams.timebase = empty_timebase(streams);
    const auto host = [](double s) { return HostTime{std::chrono::nanoseconds{std::llround(1e9 * s)}}; };
    for (std::int64_t n = 0; n < 480000; n += 240)
        add(streams, PlayTime{{n}, host(static_cast<double>(n) / 48000)});
    for (std::int64_t n = 0; n < 40000; n += 40)
        add(streams,
            AccelBlock{.first = {n}, .arrived = host(static_cast<double>(n + 39) / 4000), .size = 40});
    for (std::int64_t n = 0; n < 480000; n += 24000)
        streams.changes.push_back({.command = {}, .first = {n}, .ramp = 2400});
    streams.cameras.push_back({});
    streams.tracks.push_back({});
    for (std::int64_t n = 0; n < 1000; ++n)
        streams.tracks[0].tracks.push_back(
            {.tick = {n}, .time = master_time(0.01 * static_cast<double>(n)), .fix = {}});
    return streams;
}

TEST(TailTest, HasLastSecondsOfAllStreams) {
    const acquisition::Streams tail = tail_of(long_streams(), 8);
    EXPECT_EQ(tail.played.front().tick.n, 8 * 48000);
    EXPECT_EQ(tail.played.back().tick.n, 480000 - 240);
    // The first block that ends at 8 s or later; rounding may include or omit a block that ends at 8 s.
    EXPECT_NEAR(static_cast<double>(tail.blocks.front().first.n), 8 * 4000, 40);
    EXPECT_TRUE(has(tail.blocks.front().quality, Quality::gap));
    EXPECT_FALSE(has(tail.blocks[1].quality, Quality::gap));
    EXPECT_EQ(tail.tracks[0].tracks.front().tick.n, 800);
    EXPECT_EQ(tail.tracks[0].tracks.size(), 200U);
    // The ramp at 8 s starts from the previous drive, so the previous drive is needed too.
    ASSERT_GE(tail.changes.size(), 2U);
    EXPECT_EQ(tail.changes[0].first.n, 7.5 * 48000);
}

TEST(TailTest, ShortRunIsComplete) {
    const acquisition::Streams streams = long_streams(), tail = tail_of(streams, -1);
    EXPECT_EQ(tail.blocks.size(), streams.blocks.size());
    EXPECT_EQ(tail.changes.size(), streams.changes.size());
    EXPECT_FALSE(has(tail.blocks.front().quality, Quality::gap));
}

TEST(TailTest, DoubtfulPeriodsAreNotReduced) {
    const MeasuredPart part = part_before({3, 5}, 4.5, 20);
    EXPECT_EQ(part.from_s, 3);
    EXPECT_NEAR(part.to_s, 4.4, 1e-9);  // two periods before
    EXPECT_NEAR(part_before({3, 5}, 9, 20).to_s, 5, 1e-9);
    for (const MeasuredPart& none : {part_before({3, 5}, 3.19, 20), part_before({3, 5}, NAN, 20),
                                     part_before({3, 5}, 1, 20), part_before({}, 4, 20)})
        EXPECT_FALSE(none.to_s > none.from_s);
}

TEST(TailTest, FileNameIsUniqueTime) {
    const SessionFolder folder;
    const auto at = std::chrono::system_clock::from_time_t(1795271405);
    EXPECT_EQ(run::trip_file(folder / ".", at).filename(), "trip-20261121T143005Z.nxs");
    folder.write("trip-20261121T143005Z.nxs", "");
    EXPECT_EQ(run::trip_file(folder / ".", at).filename(), "trip-20261121T143005Z-2.nxs");
}

}  // namespace
}  // namespace shaker::recording
