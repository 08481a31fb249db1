#include "drivers/recorded/recording_file.hpp"

#include <gtest/gtest.h>

#include <cstdio>
#include <functional>

#include "drivers/errors.hpp"
#include "drivers/recorded/h5/h5.hpp"
#include "drivers/recorded/opened_recording.hpp"
#include "tests/support/recording/small_recording.hpp"

namespace shaker::recorded {

using namespace test;
namespace {

/// Equal to the last bit: NaN equals NaN, and -0 is not 0.
void expect_same_bits(const std::vector<double>& a, const std::vector<double>& b) {
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i)
        EXPECT_EQ(std::bit_cast<std::uint64_t>(a[i]), std::bit_cast<std::uint64_t>(b[i])) << "value " << i;
}

/// Writes data and reads them back.
class SessionFileTest : public testing::Test {
protected:
    SessionFileTest() {
        write_session(written_, file_);
        read_ = read_session(file_);
    }
    SessionFolder folder_;
    std::filesystem::path file_ = folder_ / "small.h5";
    Session written_ = small_session();
    Session read_;
};

TEST_F(SessionFileTest, HeaderIsReadBack) {
    const RecordingHeader &a = written_.header, &b = read_.header;
    EXPECT_EQ(b.title, a.title);
    EXPECT_EQ(b.kind, a.kind);
    EXPECT_EQ(b.config, a.config);
    EXPECT_EQ(b.rig, "");
    EXPECT_EQ(b.frequency_hz, a.frequency_hz);
    EXPECT_EQ(b.pictures, a.pictures);
    EXPECT_EQ(b.started, a.started);
    EXPECT_EQ(b.user, a.user);
    EXPECT_EQ(b.dac.name, a.dac.name);
    EXPECT_EQ(b.dac.rate_hz, a.dac.rate_hz);
    EXPECT_EQ(b.dac.full_scale_V, a.dac.full_scale_V);
    EXPECT_EQ(b.accelerometer.name, a.accelerometer.name);
    EXPECT_EQ(b.accelerometer.rate_hz, a.accelerometer.rate_hz);
    EXPECT_EQ(b.accelerometer.offset_counts, a.accelerometer.offset_counts);
    EXPECT_EQ(b.accelerometer.mps2_per_count, a.accelerometer.mps2_per_count);
    EXPECT_EQ(b.accelerometer.first_sample_s, a.accelerometer.first_sample_s);
    EXPECT_EQ(b.accelerometer.clock_uncertainty_s, a.accelerometer.clock_uncertainty_s);
    EXPECT_EQ(b.accelerometer.shaker_axis, a.accelerometer.shaker_axis);
    EXPECT_EQ(b.accelerometer.calibration, "");
    EXPECT_EQ(read_.note, written_.note);
}

TEST(AnalogSensorFileTest, AxesAndGravityAreReadBack) {
    const SessionFolder folder;
    EXPECT_EQ(read_session([&] {
                  write_session(small_session(), folder / "usual.h5");
                  return folder / "usual.h5";
              }())
                  .header.accelerometer.axes,
              3);
    Session written = small_session();
    written.header.accelerometer.axes = 1;
    written.header.accelerometer.gravity = false;
    write_session(written, folder / "analog.h5");
    const AccelerometerInfo b = read_session(folder / "analog.h5").header.accelerometer;
    EXPECT_EQ(b.axes, 1);
    EXPECT_FALSE(b.gravity);
}

TEST(CalibratedSensorFileTest, GainMatrixAndTextOfTheCalibrationAreReadBack) {
    const SessionFolder folder;
    Session written = small_session();
    AccelerometerInfo& a = written.header.accelerometer;
    a.calibration = "# dated\ndate = \"2026-11-26\"\n";
    a.cross_mps2_per_count = {{{0, 1e-7, -2e-7}, {3e-7, 0, 4e-7}, {-5e-7, 6e-7, 0}}};
    write_session(written, folder / "calibrated.h5");
    const AccelerometerInfo b = read_session(folder / "calibrated.h5").header.accelerometer;
    EXPECT_EQ(b.calibration, a.calibration);
    EXPECT_EQ(b.acceleration({1000, -200, 30}), a.acceleration({1000, -200, 30}));
}

TEST(CalibratedCameraFileTest, LensTiltAndErrorAreReadBack) {
    const SessionFolder folder;
    Session written = small_session();
    View& a = written.header.views[0];
    a.scale_error = 2e-4;
    a.lens = {{160.5, 48.25}, 1500, -0.2, 0.01, 1e-3, -2e-3};
    a.tilt_deg = {3, -0.5};
    a.calibration = "date = \"2026-11-26\"\n";
    write_session(written, folder / "camera.h5");
    const std::vector<View> views = read_session(folder / "camera.h5").header.views;
    EXPECT_EQ(views[0].scale_error, a.scale_error);
    EXPECT_EQ(views[0].lens, a.lens);
    EXPECT_EQ(views[0].tilt_deg, a.tilt_deg);
    EXPECT_EQ(views[0].calibration, a.calibration);
    EXPECT_EQ(views[1].lens, Lens{});
    EXPECT_EQ(views[1].scale_error, 0);
}

TEST_F(SessionFileTest, ViewsAndTargetsAreReadBackInOrder) {
    ASSERT_EQ(read_.header.views.size(), 2U);
    for (std::size_t k = 0; k < 2; ++k) {
        const View &a = written_.header.views[k], &b = read_.header.views[k];
        EXPECT_EQ(b.camera, a.camera);
        EXPECT_EQ(b.mm_per_px, a.mm_per_px);
        EXPECT_EQ(b.distance_mm, a.distance_mm);
        EXPECT_EQ(b.along, a.along);
        EXPECT_EQ(b.frame_rate_hz, a.frame_rate_hz);
        EXPECT_EQ(b.exposure_s, a.exposure_s);
        ASSERT_EQ(b.targets.size(), a.targets.size());
        for (std::size_t i = 0; i < a.targets.size(); ++i) {
            const Target &t = a.targets[i], &u = b.targets[i];
            EXPECT_EQ(u.name, t.name);
            EXPECT_EQ(u.kind, t.kind);
            EXPECT_EQ(u.diameter_mm, t.diameter_mm);
            EXPECT_EQ(u.width_mm, t.width_mm);
            EXPECT_EQ(u.pitch_mm, t.pitch_mm);
            EXPECT_EQ(u.roi_px, t.roi_px);
            EXPECT_EQ(u.offset_mm, t.offset_mm);
            EXPECT_EQ(u.polarity, t.polarity);
        }
    }
}

TEST_F(SessionFileTest, DriveChangesKeepAll128BitsOfPhase) {
    ASSERT_EQ(read_.changes.size(), written_.changes.size());
    for (std::size_t i = 0; i < read_.changes.size(); ++i) {
        const DriveChange &a = written_.changes[i], &b = read_.changes[i];
        EXPECT_EQ(b.command.volts, a.command.volts);
        EXPECT_EQ(b.command.frequency, a.command.frequency);
        EXPECT_EQ(b.command.ramp_periods, a.command.ramp_periods);
        EXPECT_EQ(b.command.sequence, a.command.sequence);
        EXPECT_EQ(b.first, a.first);
        EXPECT_EQ(b.ramp, a.ramp);
        EXPECT_EQ(b.stop, a.stop);
        EXPECT_TRUE(b.phase == a.phase);
        EXPECT_TRUE(b.step == a.step);
    }
}

TEST_F(SessionFileTest, PlayTimesAreReadBack) {
    ASSERT_EQ(read_.played.size(), written_.played.size());
    for (std::size_t i = 0; i < read_.played.size(); ++i) {
        EXPECT_EQ(read_.played[i].tick, written_.played[i].tick);
        EXPECT_EQ(read_.played[i].heard, written_.played[i].heard);
        EXPECT_EQ(read_.played[i].lost, written_.played[i].lost);
    }
}

TEST_F(SessionFileTest, AccelerometerBlocksKeepTheirBoundaries) {
    ASSERT_EQ(read_.blocks.size(), written_.blocks.size());
    for (std::size_t i = 0; i < read_.blocks.size(); ++i) {
        const AccelBlock &a = written_.blocks[i], &b = read_.blocks[i];
        EXPECT_EQ(b.first, a.first);
        EXPECT_EQ(b.arrived, a.arrived);
        EXPECT_EQ(b.quality, a.quality);
        EXPECT_EQ(b.size, a.size);
        EXPECT_EQ(b.counts, a.counts);
    }
}

TEST_F(SessionFileTest, FramesOf8And16BitsAreReadBack) {
    ASSERT_EQ(read_.frames.size(), written_.frames.size());
    for (std::size_t k = 0; k < read_.frames.size(); ++k) {
        ASSERT_EQ(read_.frames[k].size(), written_.frames[k].size());
        for (std::size_t i = 0; i < read_.frames[k].size(); ++i) {
            const Frame &a = *written_.frames[k][i], &b = *read_.frames[k][i];
            EXPECT_EQ(b.tick, a.tick);
            EXPECT_EQ(b.arrived, a.arrived);
            EXPECT_EQ(b.stamp, a.stamp);
            EXPECT_EQ(b.mid_exposure, a.mid_exposure);
            EXPECT_EQ(b.quality, a.quality);
            EXPECT_EQ(b.width, a.width);
            EXPECT_EQ(b.height, a.height);
            EXPECT_EQ(b.bytes_per_pixel, a.bytes_per_pixel);
            EXPECT_EQ(b.pixels, a.pixels);
        }
    }
}

TEST_F(SessionFileTest, TablesAndNumbersAreReadBackWithNaN) {
    ASSERT_EQ(read_.walker.size(), written_.walker.size());
    for (std::size_t i = 0; i < read_.walker.size(); ++i) {
        EXPECT_EQ(read_.walker[i].name, written_.walker[i].name);
        EXPECT_EQ(read_.walker[i].units, written_.walker[i].units);
        expect_same_bits(read_.walker[i].values, written_.walker[i].values);
    }
    expect_same_bits({read_.v_D}, {written_.v_D});
}

TEST_F(SessionFileTest, SameContentIsTheSameBytes) {
    write_session(written_, folder_ / "again.h5");
    const std::string bytes = bytes_of(file_);
    EXPECT_GT(bytes.size(), 1000U);
    EXPECT_TRUE(bytes == bytes_of(folder_ / "again.h5"));
    written_.played.back().heard += std::chrono::nanoseconds{1};
    write_session(written_, folder_ / "later.h5");
    EXPECT_FALSE(bytes == bytes_of(folder_ / "later.h5"));
}

struct Walk {
    std::vector<std::string> without_units, with_time;
    int numbers = 0;
};

herr_t look_at(hid_t root, const char* name, const H5O_info_t* info, void* out) {
    auto& walk = *static_cast<Walk*>(out);
    if (info->atime != 0 || info->mtime != 0 || info->ctime != 0 || info->btime != 0)
        walk.with_time.emplace_back(name);
    if (info->type != H5O_TYPE_DATASET) return 0;
    const h5::Handle set{H5Dopen2(root, name, H5P_DEFAULT), name};
    const h5::Handle type{H5Dget_type(set.get()), name};
    if (H5Tget_class(type.get()) == H5T_STRING) return 0;
    ++walk.numbers;
    if (H5Aexists(set.get(), "units") <= 0 || h5::read_attribute_text(root, name, "units").empty())
        walk.without_units.emplace_back(name);
    return 0;
}

// The time of day would make files of the same content differ from one second to the next.
TEST_F(SessionFileTest, EveryNumberHasAUnitAndNoObjectATime) {
    const h5::Handle file = h5::open_file(file_);
    Walk walk;
    ASSERT_GE(H5Ovisit2(file.get(), H5_INDEX_NAME, H5_ITER_INC, look_at, &walk, H5O_INFO_ALL), 0);
    EXPECT_EQ(walk.without_units, std::vector<std::string>{});
    EXPECT_EQ(walk.with_time, std::vector<std::string>{});
    EXPECT_EQ(walk.numbers,
              3 + 13 + 5 + 2 * 6 + 3 + 1 + 4);  // drive, changes, blocks, cameras, table, v_D, seals
}

TEST_F(SessionFileTest, AColumnWithoutAUnitIsAPureNumber) {
    written_.header.groups[0].places[0].units = "";
    write_session(written_, folder_ / "pure.h5");
    EXPECT_EQ(RecordingReader{folder_ / "pure.h5"}.table("tracks/top/walker")[0].units, "1");
}

TEST_F(SessionFileTest, RefusesColumnWithoutPlace) {
    RecordingWriter writer{folder_ / "new.h5", small_header()};
    for (const std::function<void()>& late :
         {std::function<void()>{[&] { writer.scalar("results/late", 1); }},
          {[&] { writer.text("process/late", "x"); }},
          {[&] {
              writer.rows("results", {{"late", "1", {1}}});
          }},
          {[&] { writer.texts("results/late", {"x"}); }}}) {
        try {
            late();
            FAIL() << "a new object while others read";
        } catch (const DeviceError& e) {
            expect_in(e.what(), {"late", "no place"});
        }
    }
}

TEST_F(SessionFileTest, UnsetValuesAreUnknown) {
    { RecordingWriter{folder_ / "empty.h5", small_header()}.close(); }
    const RecordingReader reader{folder_ / "empty.h5"};
    EXPECT_TRUE(std::isnan(reader.scalar("results/v_D")));
    EXPECT_EQ(reader.text("process/note"), "");
    EXPECT_EQ(reader.numbers("tracks/top/walker/x").size(), 0U);
    EXPECT_EQ(reader.damage(), std::vector<std::string>{});
}

TEST_F(SessionFileTest, GrowingFileShowsFlushedData) {
    RecordingWriter writer{folder_ / "growing.h5", small_header()};
    const auto rows = [&] {
        return RecordingReader{folder_ / "growing.h5", RecordingReader::Open::growing}
            .numbers("tracks/top/walker/x")
            .size();
    };
    EXPECT_EQ(rows(), 0U);
    writer.rows("tracks/top/walker", written_.walker);
    EXPECT_EQ(rows(), 0U) << "it was not flushed";
    writer.flush();
    EXPECT_EQ(rows(), 3U);
    expect_in(refusal([&] { RecordingReader{folder_ / "growing.h5"}; }),
              {"growing.h5", "is being recorded by process " + std::to_string(::getpid())});
}

TEST_F(SessionFileTest, WithoutKeptFramesThereAreNoCameras) {
    written_.header.pictures = KeptPictures::off;
    write_session(written_, folder_ / "lean.h5");
    const Session lean = read_session(folder_ / "lean.h5");
    EXPECT_EQ(lean.frames.size(), 0U);
    EXPECT_EQ(lean.blocks.size(), written_.blocks.size());
    EXPECT_EQ(lean.header.views.size(), 2U);
}

TEST_F(SessionFileTest, MissingFolderIsADeviceError) {
    EXPECT_THROW((RecordingWriter{folder_ / "no" / "where.h5", small_header()}), DeviceError);
}

struct Said {
    int status;
    std::string text;
};

Said python(const std::string& program, const std::filesystem::path& file) {
    const std::string line = "/usr/bin/python3 -c '" + program + "' '" + file.string() + "' 2>&1";
    FILE* pipe = popen(line.c_str(), "r");
    if (pipe == nullptr) return {-1, "no pipe"};
    std::string text;
    for (int c = 0; (c = std::fgetc(pipe)) != EOF;) text += static_cast<char>(c);
    return {pclose(pipe), text};
}

TEST_F(SessionFileTest, PythonReadsNumbersUnitsAndFrames) {
    if (python("import h5py", file_).status != 0) {
        if (std::getenv("CI") != nullptr) FAIL() << "python3 has no h5py";
        GTEST_SKIP() << "python3 has no h5py";
    }
    const Said said = python(R"(
import h5py, sys
e = h5py.File(sys.argv[1], "r")["entry"]
print(e["title"][()].decode())
v = e["results/v_D"]
print(float(v[()]).hex(), v.attrs["units"].decode())
for camera in "top", "side":
    f = h5py.File(sys.argv[1].replace(".h5", ".frames/" + camera + ".h5"), "r")["frames"]
    print(f.shape, f.dtype, int(f[1, 3, 2]), f.attrs["units"].decode())
print(e["tracks/top/walker"].attrs["signal"].decode(), e["raw/drive/changes/step_low"].dtype)
)",
                             file_);
    ASSERT_EQ(said.status, 0) << said.text;
    EXPECT_EQ(said.text, written_.header.title + "\n-0x1.5555555555555p-2 m/s\n(3, 7, 11) uint8 " +
                             std::to_string(grey(1, 2, 3, 8)) + " count\n(2, 5, 6) uint16 " +
                             std::to_string(grey(1, 2, 3, 16)) + " count\nx uint64\n");
}

}  // namespace
}  // namespace shaker::recorded
