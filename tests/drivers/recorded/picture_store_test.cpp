// Stored pictures are read back to the bit, over several segments, and by other programs.
#include "drivers/recorded/pictures/picture_store.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <array>
#include <cstdio>
#include <fstream>
#include <random>
#include <set>

#include "drivers/errors.hpp"
#include "drivers/recorded/h5/disk_file.hpp"
#include "drivers/recorded/pictures/picture_check.hpp"
#include "drivers/recorded/pictures/picture_reader.hpp"
#include "tests/support/recording/many_pictures.hpp"

namespace shaker::recorded {

using namespace test;
namespace {

std::set<std::string> names_in(const std::filesystem::path& folder) {
    std::set<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator{folder})
        names.insert(entry.path().filename().string());
    return names;
}

void expect_pictures(const std::filesystem::path& folder, const pictures::PictureShape& shape,
                     std::uint64_t count) {
    pictures::PictureReader reader{folder, "top"};
    ASSERT_EQ(reader.count(), count);
    EXPECT_EQ(reader.shape(), shape);
    EXPECT_TRUE(reader.damaged().empty());
    for (std::uint64_t n = 1; n <= count; ++n) expect_same(*reader.read(n - 1), numbered(n, shape), n);
}

/// Output of a program followed by its exit status.
std::string said_by(const std::string& command) {
    std::string said;
    std::FILE* out = ::popen((command + " 2>&1").c_str(), "r");
    std::array<char, 256> part{};
    while (std::fgets(part.data(), part.size(), out) != nullptr) said += part.data();
    return said + "[" + std::to_string(::pclose(out)) + "]";
}

class PictureStoreTest : public testing::Test {
protected:
    void store(const pictures::PictureShape& shape, std::uint64_t count, std::uint64_t segment_frames) {
        std::filesystem::remove_all(frames_);
        pictures::PictureStore store{frames_, "top", segment_frames};
        store.prepare(shape);
        for (std::uint64_t n = 1; n <= count; ++n) ASSERT_EQ(store.add(numbered(n, shape)), n);
        store.finish();
        EXPECT_EQ(store.stored(), count);
    }
    SessionFolder folder_;
    std::filesystem::path frames_ = folder_ / "run.frames";
};

TEST_F(PictureStoreTest, ReadsBackPicturesOfAnySizeAndDepth) {
    for (const pictures::PictureShape& shape :
         {pictures::PictureShape{64, 64, 1}, pictures::PictureShape{11, 7, 1},
          pictures::PictureShape{1, 1, 1}, pictures::PictureShape{129, 33, 2},
          pictures::PictureShape{1280, 256, 1}, pictures::PictureShape{1, 1, 2}})
        for (const std::uint64_t count : {0U, 1U, 7U, 8U, 9U, 64U, 65U}) {
            SCOPED_TRACE(testing::Message() << shape.width << " x " << shape.height << " x "
                                            << shape.bytes_per_pixel << ", " << count << " pictures");
            store(shape, count, 64);
            expect_pictures(frames_, shape, count);
        }
}

// A file of the store that cannot be read at the end of the recording is an error, although others can.
TEST_F(PictureStoreTest, OwnUnreadableFileIsAnErrorAtTheEnd) {
    const pictures::PictureShape shape{37, 21, 1};
    pictures::PictureStore store{frames_, "top", 64};
    for (std::uint64_t n = 1; n <= 80; ++n) ASSERT_EQ(store.add(numbered(n, shape)), n);
    std::fstream first{frames_ / "top-0000.h5", std::ios::binary | std::ios::in | std::ios::out};
    first << "not HDF5";
    first.close();
    try {
        store.finish();
        ADD_FAILURE() << "the loss was not reported";
    } catch (const DeviceError& e) {
        EXPECT_NE(std::string{e.what()}.find("top-0000.h5"), std::string::npos) << e.what();
    }
}

TEST_F(PictureStoreTest, CutsLastSegmentToItsPictures) {
    const pictures::PictureShape shape{37, 21, 2};
    for (const std::uint64_t segment : {1U, 5U, 8U, 64U}) {
        store(shape, 3 * segment + 1, segment);
        EXPECT_EQ(names_in(frames_), (std::set<std::string>{"top.h5", "top-0000.h5", "top-0001.h5",
                                                            "top-0002.h5", "top-0003.h5"}));
        expect_pictures(frames_, shape, 3 * segment + 1);
        EXPECT_EQ(pictures::find_segment(frames_ / "top-0002.h5", "top").info.places, segment);
        EXPECT_EQ(pictures::find_segment(frames_ / "top-0003.h5", "top").info.places, 1);
    }
    store(shape, 16, 8);
    EXPECT_EQ(names_in(frames_), (std::set<std::string>{"top.h5", "top-0000.h5", "top-0001.h5"}));
}

// 7 of 8 places: not worth a copy. The disk gets the space of the eighth.
TEST_F(PictureStoreTest, LeavesALastSegmentThatIsNearlyFull) {
    const pictures::PictureShape shape{512, 256, 1};
    const auto blocks_of = [&] {
        struct stat status {};
        EXPECT_EQ(::stat((frames_ / "top-0000.h5").c_str(), &status), 0);
        return static_cast<double>(status.st_blocks) * 512;
    };
    store(shape, 56, 64);
    expect_pictures(frames_, shape, 56);
    EXPECT_EQ(pictures::find_segment(frames_ / "top-0000.h5", "top").info.places, 64);
    const auto bytes = static_cast<double>(shape.bytes());
    EXPECT_NEAR(blocks_of(), 56 * bytes, bytes);
    const pictures::PictureCheck check = pictures::finish_frames(frames_, "top");
    EXPECT_EQ(check.last, 56);
    EXPECT_TRUE(check.bad.empty());
    expect_pictures(frames_, shape, 56);
    store(shape, 32, 64);
    EXPECT_EQ(pictures::find_segment(frames_ / "top-0000.h5", "top").info.places, 32);
}

TEST_F(PictureStoreTest, SegmentHasQuarterGigabyteOrSixtyFourPictures) {
    pictures::PictureStore store{frames_, "top"};
    store.prepare({1280, 256, 1});
    const pictures::FoundSegment found = pictures::find_segment(frames_ / "top-0000.h5", "top");
    EXPECT_EQ(found.info.places % pictures::PictureSegment::block, 0);
    EXPECT_NEAR(static_cast<double>(std::filesystem::file_size(found.file)), 256e6, 3e6);
    EXPECT_EQ(found.plan.frames_at % h5::page_bytes, 0);
    pictures::PictureStore wide{frames_, "wide"};
    wide.prepare({4096, 4096, 1});
    EXPECT_EQ(pictures::find_segment(frames_ / "wide-0000.h5", "wide").info.places, 64);
}

TEST_F(PictureStoreTest, SyncedPicturesSurviveWithoutFinish) {
    const pictures::PictureShape shape{50, 40, 1};
    std::mt19937 random{3};
    pictures::PictureStore store{frames_, "top", 20};
    for (std::uint64_t n = 1; n <= 100; ++n) {
        store.add(numbered(n, shape));
        EXPECT_LE(n - store.stored(), 7U);
        if (random() % 5 == 0) {
            store.sync();
            EXPECT_EQ(store.stored(), n);
            expect_pictures(frames_, shape, n);
        }
    }
}

TEST_F(PictureStoreTest, WritesLargerBlocksWhileMoreFollow) {
    const pictures::PictureShape shape{50, 40, 1};
    std::mt19937 random{4};
    pictures::PictureStore store{frames_, "top", 300};
    std::uint64_t n = 0;
    const auto add = [&](bool more) {
        ++n;
        store.add(numbered(n, shape), more);
    };
    while (n < pictures::PictureSegment::large_block - 1) add(true);
    EXPECT_EQ(store.stored(), 0);
    add(true);
    EXPECT_EQ(store.stored(), pictures::PictureSegment::large_block);
    for (int i = 0; i < 20; ++i) add(true);
    EXPECT_EQ(store.stored(), pictures::PictureSegment::large_block);
    add(false);
    EXPECT_EQ(store.stored(), n);
    while (n < 1000) {
        const bool more = random() % 20 != 0;
        add(more);
        EXPECT_LT(n - store.stored(),
                  more ? pictures::PictureSegment::large_block : pictures::PictureSegment::block);
    }
    store.finish();
    expect_pictures(frames_, shape, n);
}

TEST_F(PictureStoreTest, TwoCamerasShareAFolder) {
    pictures::PictureStore top{frames_, "top", 8}, side{frames_, "top-2", 8};
    for (std::uint64_t n = 1; n <= 20; ++n) {
        top.add(numbered(n, {16, 9, 1}));
        if (n % 2 == 0) side.add(numbered(n / 2, {9, 16, 2}));
    }
    top.finish();
    side.finish();
    expect_pictures(frames_, {16, 9, 1}, 20);
    pictures::PictureReader reader{frames_, "top-2"};
    ASSERT_EQ(reader.count(), 10);
    expect_same(*reader.read(9), numbered(10, {9, 16, 2}), 10);
}

TEST_F(PictureStoreTest, NobodyElseHasTheFolderWhileItWrites) {
    using h5::FileLock, h5::Sharing;
    {
        pictures::PictureStore top{frames_, "top", 8}, side{frames_, "side", 8};
        for (pictures::PictureStore* store : {&top, &side}) store->prepare({8, 8, 1});
        EXPECT_FALSE(FileLock::take_folder(frames_, Sharing::alone));
    }
    const auto recovery = FileLock::take_folder(frames_, Sharing::alone);
    ASSERT_TRUE(recovery);
    EXPECT_FALSE(FileLock::take_folder(frames_, Sharing::alone));
    pictures::PictureStore late{frames_, "late", 8};
    EXPECT_THROW(late.prepare({8, 8, 1}), DeviceError);
}

TEST_F(PictureStoreTest, FollowsNoLinkToAFolder) {
    std::filesystem::create_directories(folder_ / "others");
    std::filesystem::create_directory_symlink(folder_ / "others", frames_);
    pictures::PictureStore store{frames_, "top", 8};
    expect_in(refusal([&] { store.prepare({8, 8, 1}); }), {"run.frames: is a link or not a folder"});
    EXPECT_TRUE(std::filesystem::is_empty(folder_ / "others"));
}

TEST_F(PictureStoreTest, StoresNothingAfterFinish) {
    const pictures::PictureShape shape{16, 9, 1};
    pictures::PictureStore store{frames_, "top", 8};
    store.add(numbered(1, shape));
    store.finish();
    EXPECT_EQ(store.add(numbered(2, shape)), 0);
    expect_pictures(frames_, shape, 1);
    pictures::PictureStore never{frames_, "side", 8};
    never.finish();
    EXPECT_EQ(refusal([&] { pictures::PictureReader(frames_, "side"); }),
              frames_.string() + ": no pictures of camera \"side\"");
}

TEST_F(PictureStoreTest, RefusesWrongSizeOnceAndStops) {
    pictures::PictureStore store{frames_, "top", 8};
    store.add(numbered(1, {16, 9, 1}));
    EXPECT_THROW(store.add(numbered(2, {9, 16, 1})), DeviceError);
    EXPECT_EQ(store.add(numbered(2, {16, 9, 1})), 0);
    store.finish();
    EXPECT_EQ(store.stored(), 0) << "the block was not complete";
    EXPECT_EQ(pictures::PictureReader(frames_, "top").count(), 0);
}

TEST_F(PictureStoreTest, NeverOverwritesPictures) {
    store({16, 9, 1}, 3, 8);
    expect_in(refusal([&] { pictures::PictureStore(frames_, "top"); }), {"top-0000.h5", "already exists"});
    expect_pictures(frames_, {16, 9, 1}, 3);
}

TEST_F(PictureStoreTest, RefusesInvalidNamesAndSizes) {
    for (const char* name : {"", ".top", "a/b", "../top", "a\nb", "top-0001", "-0000"})
        expect_in(refusal([&] { pictures::PictureStore(frames_, name); }), {"camera \"", "name"});
    expect_in(refusal([&] { pictures::PictureStore(frames_, std::string(65, 'a')); }), {"64"});
    for (const char* name : {"top", "Läufer 2", "top-001", "0000", "a.h5"})
        EXPECT_EQ(refusal([&] { pictures::PictureStore(frames_, name); }), "accepted");
    for (const pictures::PictureShape& shape :
         {pictures::PictureShape{0, 4, 1}, pictures::PictureShape{4, 0, 1}, pictures::PictureShape{4, 4, 3},
          pictures::PictureShape{65536, 4, 1}, pictures::PictureShape{4, 4, 0}})
        expect_in(refusal([&] { pictures::PictureStore(frames_, "top").prepare(shape); }), {"65535", "top"});
    EXPECT_FALSE(std::filesystem::exists(frames_));
}

TEST_F(PictureStoreTest, OtherProgramsReadOneArray) {
    const pictures::PictureShape shape{37, 21, 2};
    store(shape, 21, 8);
    const std::string script = folder_
                                   .write("read.py", R"(
import h5py, os, sys, zlib
with h5py.File(sys.argv[1] + "/top.h5", "r") as f:
    frames, index = f["frames"], f["index"]
    print(frames.shape, frames.dtype, frames.attrs["units"].decode(), f.attrs["camera"].decode(), frames.is_virtual)
    print(list(index["number"]) == list(range(1, 22)), index["tick"][20], index["quality"][6])
    print(zlib.crc32(frames[...].tobytes()), os.getcwd())
with h5py.File(sys.argv[1] + "/top-0002.h5", "r") as f:
    print(f["frames"].shape, f["frames"].chunks, dict(f.attrs)["first_number"], f["frames"].id.get_offset() % 4096)
)")
                                   .string();
    std::string pixels;
    for (std::uint64_t n = 1; n <= 21; ++n) {
        const Frame f = numbered(n, shape);
        pixels.append(reinterpret_cast<const char*>(f.pixels.data()), f.pixels.size());
    }
    folder_.write("pixels", pixels);
    const std::string crc =
        said_by("python3 -c 'import sys, zlib; print(zlib.crc32(open(sys.argv[1], \"rb\").read()))' '" +
                (folder_ / "pixels").string() + "'");
    const std::string expected = "(21, 21, 37) uint16 count top True\nTrue 62 7\n" +
                                 crc.substr(0, crc.find('\n')) + " /\n(5, 21, 37) None 17 0\n[0]";
    EXPECT_EQ(said_by("cd / && /usr/bin/python3 '" + script + "' '" + frames_.string() + "'"), expected);
    expect_in(said_by("h5ls '" + (frames_ / "top.h5").string() + "'"), {"frames", "{21, 21, 37}", "[0]"});
}

}  // namespace
}  // namespace shaker::recorded
