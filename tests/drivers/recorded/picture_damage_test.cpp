// Segments that are damaged or come from another program: an InputError with the place, never a crash.
#include <gtest/gtest.h>

#include <algorithm>

#include "drivers/recorded/pictures/picture_check.hpp"
#include "drivers/recorded/pictures/picture_reader.hpp"
#include "drivers/recorded/pictures/picture_store.hpp"
#include "drivers/recorded/pictures/segment.hpp"
#include "tests/support/recording/many_pictures.hpp"
#include "tests/support/recording/mutants_of_file.hpp"
#include "tests/support/recording/without_checksums.hpp"

namespace shaker::recorded {

using namespace test;
namespace {

constexpr pictures::PictureShape shape{16, 12, 1};
constexpr std::uint64_t pictures = 20;

/// Reads everything.
void read_all(const std::filesystem::path& folder) {
    pictures::PictureReader reader{folder, "top"};
    for (std::uint64_t k = 0; k < reader.count(); ++k) reader.read(k);
    pictures::verify_frames(folder, "top");
}

class FrameDamageTest : public testing::Test {
protected:
    FrameDamageTest() {
        pictures::PictureStore store{frames_, "top", 64};
        for (std::uint64_t n = 1; n <= pictures; ++n) store.add(numbered(n, shape));
        store.finish();
        good_ = bytes_of(file_);
    }
    void put(const std::string& bytes) { std::ofstream{file_, std::ios::binary} << bytes; }
    /// Refusal after `change` of the root group.
    std::string refusal_after(const std::function<void(hid_t)>& change) {
        put(good_);
        {
            const h5::Handle file{H5Fopen(file_.c_str(), H5F_ACC_RDWR, H5P_DEFAULT), "file"};
            change(h5::open_group(file.get(), "/").get());
        }
        return refusal([&] { read_all(frames_); });
    }
    std::string refusal_with_attribute(const std::string& name, const auto& value) {
        return refusal_after([&](hid_t root) {
            h5::check(H5Adelete(root, name.c_str()), name);
            h5::set_attribute(root, name, value);
        });
    }
    /// Replaces one of our data sets by another one.
    std::string refusal_with(
        const std::string& name, hid_t type, std::vector<hsize_t> extent,
        const std::function<void(hid_t)>& how = [](hid_t) {}) {
        return refusal_after([&](hid_t root) {
            h5::check(H5Ldelete(root, name.c_str(), H5P_DEFAULT), name);
            const h5::Handle create{H5Pcreate(H5P_DATASET_CREATE), name};
            how(create.get());
            const h5::Handle space{H5Screate_simple(static_cast<int>(extent.size()), extent.data(), nullptr),
                                   name};
            const h5::Handle set{
                H5Dcreate2(root, name.c_str(), type, space.get(), H5P_DEFAULT, create.get(), H5P_DEFAULT),
                name};
        });
    }

    SessionFolder folder_;
    std::filesystem::path frames_ = folder_ / "run.frames", file_ = pictures::segment_file(frames_, "top", 0);
    std::string good_;
};

void early(hid_t create) { h5::check(H5Pset_alloc_time(create, H5D_ALLOC_TIME_EARLY), "allocation"); }

TEST_F(FrameDamageTest, RefusesFileThatIsNoSegment) {
    for (const std::string& bytes : {std::string{}, std::string{"x"}, std::string(5000, 'x')}) {
        put(bytes);
        expect_in(refusal([&] { read_all(frames_); }), {"top-0000.h5", "not an HDF5 file"});
    }
    std::filesystem::remove(file_);
    { h5::create_file(file_); }
    expect_in(refusal([&] { read_all(frames_); }), {"top-0000.h5", "/frames"});
    std::filesystem::remove(file_);
    expect_in(refusal([&] { read_all(frames_); }), {"no pictures of camera \"top\""});
    expect_in(refusal([&] { read_all(folder_ / "none"); }), {"none", "no pictures"});
    std::filesystem::create_directory(file_);
    expect_in(refusal([&] { read_all(frames_); }), {"top-0000.h5"});
}

TEST_F(FrameDamageTest, RefusesTruncatedSegments) {
    for (std::size_t i = 0; i < 64; ++i) {
        put(good_.substr(0, good_.size() * i / 64));
        EXPECT_NE(refusal([&] { read_all(frames_); }), "accepted") << i << "/64 of the file";
    }
}

TEST_F(FrameDamageTest, RefusesUnknownShapesAndTypes) {
    const hid_t u8 = H5T_STD_U8LE, record = H5T_STD_U64LE;
    expect_in(refusal_with("frames", u8, {pictures, 12}, early), {"/frames", "2 axes"});
    expect_in(refusal_with("frames", u8, {pictures, 12, 16, 1}, early), {"/frames", "4 axes"});
    expect_in(refusal_with("frames", u8, {pictures, 0, 16}), {"/frames", "16 x 0"});
    expect_in(refusal_with("frames", u8, {0, hsize_t{1} << 40U, hsize_t{1} << 40U}), {"/frames", "65535"});
    expect_in(refusal_with("frames", u8, {pictures, 12, 17}, early), {"@width is 16, not 17"});
    expect_in(refusal_with("frames", u8, {pictures - 1, 12, 16}, early), {"/index", "one record"});
    for (const hid_t other : {H5T_IEEE_F64LE, H5T_STD_I8LE, H5T_STD_U16BE, H5T_STD_U32LE, H5T_STD_I16LE})
        expect_in(refusal_with("frames", other, {pictures, 12, 16}, early), {"/frames", "8 or 16 bits"});
    expect_in(refusal_with("frames", H5T_STD_U16LE, {pictures, 12, 16}, early),
              {"@bytes_per_pixel is 1, not 2"});
    expect_in(refusal_with("index", record, {pictures}, early), {"/index", "unknown type of record"});
    const h5::Handle changed = pictures::record_type();
    h5::check(H5Tinsert(changed.get(), "more", offsetof(pictures::PictureRecord, reserved), H5T_STD_U8LE),
              "more");
    expect_in(refusal_with("index", changed.get(), {pictures}, early), {"/index", "unknown type of record"});
    expect_in(refusal_with("index", pictures::record_type().get(), {pictures, 1}, early),
              {"/index", "one record"});
    EXPECT_NE(refusal_with("frames", u8, {pictures, 12, 16}, early), "accepted") << "there are no pixels";
}

TEST_F(FrameDamageTest, RefusesOversizedShapesBeforeAllocating) {
    constexpr hsize_t huge = hsize_t{1} << 40U;
    expect_in(refusal_with("frames", H5T_STD_U8LE, {huge, 12, 16}), {"frames", "larger than the file"});
    expect_in(refusal_with("frames", H5T_STD_U8LE, {huge, huge, huge}), {"frames", "larger than the file"});
    expect_in(refusal_with("index", pictures::record_type().get(), {huge}),
              {"index", "larger than the file"});
    expect_in(refusal_with("index", pictures::record_type().get(), {pictures}),
              {"/index", "not allocated in the file"});
}

TEST_F(FrameDamageTest, RefusesLinkedOrCompressedData) {
    const hid_t u8 = H5T_STD_U8LE;
    const std::vector<hsize_t> extent{pictures, 12, 16}, chunk{1, 12, 16};
    expect_in(refusal_with("frames", u8, extent,
                           [&](hid_t c) { h5::check(H5Pset_chunk(c, 3, chunk.data()), "chunk"); }),
              {"/frames", "not contiguous"});
    expect_in(refusal_with("frames", u8, extent,
                           [&](hid_t c) {
                               h5::check(H5Pset_chunk(c, 3, chunk.data()), "chunk");
                               h5::check(H5Pset_shuffle(c), "filter");
                           }),
              {"frames", "compressed"});
    expect_in(
        refusal_with("frames", u8, extent,
                     [&](hid_t c) { h5::check(H5Pset_external(c, "/etc/passwd", 0, 3840), "external"); }),
        {"frames", "other files"});
    const auto linked = [&](const std::function<herr_t(hid_t)>& link) {
        return refusal_after([&](hid_t root) {
            h5::check(H5Ldelete(root, "frames", H5P_DEFAULT), "frames");
            h5::check(link(root), "link");
        });
    };
    std::filesystem::copy_file(file_, frames_ / "other.h5");
    // After it has opened a file, this process cannot create such links.
    const std::string change =
        "/usr/bin/python3 -c \"import h5py; f = h5py.File('" + file_.string() +
        "', 'r+'); del f['frames']; f['frames'] = h5py.ExternalLink('other.h5', '/frames')\"";
    expect_in(refusal_after([&](hid_t) {}), {"accepted"});
    ASSERT_EQ(std::system(change.c_str()), 0);
    expect_in(refusal([&] { read_all(frames_); }), {"/frames", "is a link"});
    expect_in(
        linked([](hid_t root) { return H5Lcreate_soft("/index", root, "frames", H5P_DEFAULT, H5P_DEFAULT); }),
        {"/frames", "is a link"});
    expect_in(linked([](hid_t) { return 0; }), {"no /frames"});
    std::filesystem::copy_file(frames_ / "top.h5", file_, std::filesystem::copy_options::overwrite_existing);
    expect_in(refusal([&] { read_all(frames_); }), {"other files"});
}

TEST_F(FrameDamageTest, NamesInconsistentAttributes) {
    expect_in(refusal_with_attribute("camera", std::string{"side"}), {"@camera is \"side\"", "top"});
    expect_in(refusal_with_attribute("camera", 3.0), {"camera"});
    expect_in(refusal_with_attribute("width", std::int64_t{17}), {"@width is 17, not 16"});
    expect_in(refusal_with_attribute("height", nan), {"@height"});
    for (const double first : {0.0, -1.0, 0.5, nan, 1e300})
        expect_in(refusal_with_attribute("first_number", first), {"@first_number"});
    expect_in(refusal_after([](hid_t root) { H5Adelete(root, "first_number"); }), {"first_number"});
    expect_in(refusal_with_attribute("first_number", std::int64_t{100}),
              {"picture 1 is in no readable file"});
}

TEST_F(FrameDamageTest, SegmentsThatContradictEachOtherAreRefused) {
    const std::filesystem::path second = pictures::segment_file(frames_, "top", 1);
    std::filesystem::copy_file(file_, second);
    expect_in(refusal([&] { read_all(frames_); }), {"top-0001.h5", "picture 1", "another file"});
    pictures::PictureStore other{folder_ / "other", "top", 8};
    for (std::uint64_t n = 1; n <= 16; ++n) other.add(numbered(n, {12, 16, 1}));
    other.finish();
    std::filesystem::copy_file(pictures::segment_file(folder_ / "other", "top", 1), second,
                               std::filesystem::copy_options::overwrite_existing);
    put(good_);
    expect_in(refusal([&] { read_all(frames_); }), {"picture 9", "another file"});
    std::filesystem::copy_file(pictures::segment_file(folder_ / "other", "top", 0), file_,
                               std::filesystem::copy_options::overwrite_existing);
    const h5::Handle file{H5Fopen(second.c_str(), H5F_ACC_RDWR, H5P_DEFAULT), "file"};
    EXPECT_EQ(refusal([&] { pictures::PictureReader(frames_, "top"); }), "accepted");
}

/// The first segment with damage, half of it in the structure at its begin, as its folder is read.
Mutants mutants_of(const std::filesystem::path& folder, const std::filesystem::path& file, int mutants,
                   std::uint64_t seed) {
    return read_mutants({file, bytes_of(file), 1000, [&] { read_all(folder); }}, mutants, seed);
}

TEST_F(FrameDamageTest, ReadsOrRefusesMutants) {
    const Mutants all = mutants_of(frames_, file_, 400, 30);
    EXPECT_GT(all.refused, 100);
    EXPECT_EQ(all.wrong + all.died, 0) << all.example;
    EXPECT_LT(all.peak_MB, most_MB);
}

// The checksums of HDF5 stop most mutants before our code sees them, so these mutants have none. HDF5 1.10.8
// itself reads beyond the end of some damaged messages: their processes may die.
TEST_F(FrameDamageTest, MutantsWithoutChecksumsAreReadOrRefusedToo) {
    copy_without_checksums(file_, folder_ / "old.h5");
    {
        const h5::Handle file{H5Fopen((folder_ / "old.h5").c_str(), H5F_ACC_RDWR, H5P_DEFAULT), "file"};
        const h5::Handle root = h5::open_group(file.get(), "/");
        h5::set_attribute(root.get(), "camera", std::string{"top"});
        for (const auto& [name, value] : {std::pair{"width", 16}, std::pair{"height", 12},
                                          std::pair{"bytes_per_pixel", 1}, std::pair{"first_number", 1}})
            h5::set_attribute(root.get(), name, std::int64_t{value});
    }
    put(bytes_of(folder_ / "old.h5"));
    ASSERT_EQ(bytes_of(file_).find("OHDR"), std::string::npos) << "there are headers with checksums";
    ASSERT_EQ(refusal([&] { read_all(frames_); }), "accepted");
    const Mutants all = mutants_of(frames_, file_, 600, 31);
    EXPECT_GT(all.refused, 60);
    EXPECT_EQ(all.wrong, 0) << all.example;
    EXPECT_LE(all.died, 6) << all.example;
    EXPECT_LT(all.peak_MB, most_MB);
}

}  // namespace
}  // namespace shaker::recorded
