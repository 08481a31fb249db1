// A recording with pictures by a version that followed targets otherwise.
#include <gtest/gtest.h>

#include <fstream>

#include "daemon/recording/tables/places.hpp"
#include "drivers/recorded/h5/h5.hpp"
#include "tests/support/program.hpp"

namespace shaker::recording {
namespace {

using test::Outcome;
using test::shakerd;

/// Moves the walker by 0.01 px in one picture, and marks the file as one of the version before.
void make_older(const std::filesystem::path& recording) {
    const h5::Handle file{H5Fopen(recording.c_str(), H5F_ACC_RDWR, H5P_DEFAULT), "file"};
    const h5::Handle process = h5::open_group(file.get(), "entry/process");
    h5::check(H5Adelete(process.get(), "schema"), "schema");
    h5::set_attribute(process.get(), "schema", std::int64_t{tracks_since - 1});
    const std::string path = "entry/tracks/top/walker/x_px";
    const h5::Handle set{H5Dopen2(file.get(), path.c_str(), H5P_DEFAULT), path};
    const h5::Handle space{H5Dget_space(set.get()), path};
    const hsize_t row = 7, one = 1;
    h5::check(H5Sselect_hyperslab(space.get(), H5S_SELECT_SET, &row, nullptr, &one, nullptr), path);
    const h5::Handle memory{H5Screate_simple(1, &one, nullptr), path};
    double x = 0;
    h5::check(H5Dread(set.get(), H5T_NATIVE_DOUBLE, memory.get(), space.get(), H5P_DEFAULT, &x), path);
    x += 0.01;
    h5::check(H5Dwrite(set.get(), H5T_NATIVE_DOUBLE, memory.get(), space.get(), H5P_DEFAULT, &x), path);
}

TEST(TrackChangesTest, AnOlderRecordingSaysHowFarItsTracksMove) {
    const std::filesystem::path folder = test::fresh_folder();
    std::ofstream{folder / "slow.toml"} << "[top]\nframe_rate_hz = 200\n[side]\nframe_rate_hz = 200\n";
    const Outcome run = shakerd(
        "run --no-identify --scene slow.toml --gamma 1.2g --periods 4 --frames region -o run.nxs", folder);
    ASSERT_EQ(run.status, 0) << run.err;
    const Outcome own = shakerd("replay run.nxs", folder);
    EXPECT_EQ(own.status, 0) << own.err;
    EXPECT_NE(own.err.find("from frames"), std::string::npos) << own.err;
    make_older(folder / "run.nxs");
    EXPECT_NE(shakerd("replay run.nxs", folder).err.find("from tracks"), std::string::npos);
    const Outcome raw = shakerd("replay --from raw run.nxs", folder);
    EXPECT_EQ(raw.status, 0) << raw.err;
    EXPECT_NE(raw.out.find("replay: track moved, tracks/top/walker: "), std::string::npos) << raw.out;
    EXPECT_NE(raw.out.find("at most 0.01 (stated error 0.0"), std::string::npos) << raw.out;
    EXPECT_NE(raw.out.find("the streams are followed again"), std::string::npos) << raw.out;
    EXPECT_EQ(raw.out.find("tracks/side"), std::string::npos) << raw.out;
}

}  // namespace
}  // namespace shaker::recording
