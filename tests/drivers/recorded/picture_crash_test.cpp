// After the death of the picture writer all written pictures are found, and no damaged picture is accepted.
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <csignal>
#include <new>
#include <random>
#include <thread>

#include "drivers/recorded/h5/disk_file.hpp"
#include "drivers/recorded/pictures/picture_check.hpp"
#include "drivers/recorded/pictures/picture_reader.hpp"
#include "drivers/recorded/pictures/picture_store.hpp"
#include "tests/support/recording/many_pictures.hpp"

namespace shaker::recorded {

using namespace test;
namespace {

/// All files in a folder, by name.
std::map<std::string, std::string> contents(const std::filesystem::path& folder) {
    std::map<std::string, std::string> all;
    for (const auto& entry : std::filesystem::directory_iterator{folder})
        all[entry.path().filename().string()] = bytes_of(entry.path());
    return all;
}

void change(const std::filesystem::path& file, std::uint64_t at, const std::function<void(char&)>& how) {
    std::fstream stream{file, std::ios::binary | std::ios::in | std::ios::out};
    char byte = 0;
    stream.seekg(static_cast<std::streamoff>(at)).get(byte);
    how(byte);
    stream.seekp(static_cast<std::streamoff>(at)).put(byte);
    ASSERT_TRUE(stream.good());
}

/// A number that a child process counts up, as its parent sees it.
class Progress {
public:
    Progress() {
        void* const shared =
            ::mmap(nullptr, sizeof *count_, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
        if (shared == MAP_FAILED) throw std::bad_alloc{};
        count_ = new (shared) std::atomic<std::uint64_t>{0};
    }
    ~Progress() { ::munmap(count_, sizeof *count_); }
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    void set(std::uint64_t n) noexcept { *count_ = n; }
    [[nodiscard]] std::uint64_t now() const noexcept { return *count_; }
    /// Waits for this number; false when the child ends before.
    [[nodiscard]] bool reached(std::uint64_t n, pid_t child) const {
        while (now() < n) {
            siginfo_t end{};
            if (::waitid(P_PID, static_cast<id_t>(child), &end, WEXITED | WNOHANG | WNOWAIT) != 0 ||
                end.si_pid != 0)
                return false;
            std::this_thread::sleep_for(std::chrono::microseconds{100});
        }
        return true;
    }

private:
    std::atomic<std::uint64_t>* count_ = nullptr;
};

/// Starts `work` in a process of its own, which an exception ends.
pid_t in_child(const std::function<void()>& work) {
    const pid_t child = fork();
    if (child == 0)
        [&]() noexcept {
            work();
            ::_exit(0);
        }();
    return child;
}

class FrameCrashTest : public testing::Test {
protected:
    /// Stores pictures in a separate process, which ends without closing the store after picture `last`.
    void store_and_die(std::uint64_t last, std::uint64_t segment) {
        std::filesystem::remove_all(frames_);
        const pid_t child = in_child([&] {
            pictures::PictureStore store{frames_, "top", segment};
            store.prepare(shape_);
            for (std::uint64_t n = 1; n <= last; ++n) store.add(numbered(n, shape_));
            ::_exit(0);
        });
        int status = 0;
        ASSERT_EQ(::waitpid(child, &status, 0), child);
        ASSERT_EQ(status, 0);
    }
    void store_all(std::uint64_t last, std::uint64_t segment) {
        std::filesystem::remove_all(frames_);
        pictures::PictureStore store{frames_, "top", segment};
        for (std::uint64_t n = 1; n <= last; ++n) store.add(numbered(n, shape_));
        store.sync();
    }
    /// Checks that these pictures are refused and all others are unchanged.
    void expect_whole_but(const std::vector<std::uint64_t>& bad, std::uint64_t count) {
        pictures::PictureReader reader{frames_, "top"};
        ASSERT_EQ(reader.count(), count);
        for (std::uint64_t n = 1; n <= count; ++n)
            if (std::ranges::find(bad, n) != bad.end())
                EXPECT_NE(refusal([&] { reader.read(n - 1); }), "accepted") << n;
            else
                expect_same(*reader.read(n - 1), numbered(n, shape_), n);
    }
    [[nodiscard]] pictures::FoundSegment segment(int k) const {
        return pictures::find_segment(pictures::segment_file(frames_, "top", static_cast<std::uint64_t>(k)),
                                      "top");
    }
    static std::uint64_t record_at(const pictures::FoundSegment& s, std::uint64_t place) {
        return s.plan.index_at + place * sizeof(pictures::PictureRecord);
    }
    [[nodiscard]] std::uint64_t pixels_at(const pictures::FoundSegment& s, std::uint64_t place) const {
        return s.plan.frames_at + place * shape_.bytes();
    }

    pictures::PictureShape shape_{61, 23, 2};
    SessionFolder folder_;
    std::filesystem::path frames_ = folder_ / "run.frames";
};

TEST_F(FrameCrashTest, DyingWriterLosesAtMostItsUnwrittenBlock) {
    std::mt19937 random{7};
    for (int run = 0; run < 60; ++run) {
        const std::uint64_t last = random() % 100, segment = 1 + random() % 30;
        SCOPED_TRACE(testing::Message() << last << " pictures, " << segment << " in a segment");
        store_and_die(last, segment);
        const pictures::PictureCheck before = pictures::verify_frames(frames_, "top");
        EXPECT_EQ(before.whole.size(), before.last);
        EXPECT_TRUE(before.bad.empty() && before.damaged.empty());
        EXPECT_LE(before.last, last);
        EXPECT_LT(last - before.last, pictures::PictureSegment::block);
        expect_whole_but({}, before.last);
        const pictures::PictureCheck after = pictures::finish_frames(frames_, "top");
        EXPECT_EQ(after.whole, before.whole);
        expect_whole_but({}, before.last);
        const auto files = contents(frames_);
        EXPECT_EQ(files.size(), 1 + std::max<std::uint64_t>(1, (before.last + segment - 1) / segment));
        pictures::finish_frames(frames_, "top");
        EXPECT_TRUE(contents(frames_) == files) << "once more changed something";
    }
}

// Killed at random times: also while a segment is created, in a write, between pixels and records. Most
// writers first store a number of pictures, however slow the disk is.
TEST_F(FrameCrashTest, KilledWriterLosesNoWholePicture) {
    std::mt19937 random{11};
    std::uint64_t stored = 0;
    for (int run = 0; run < 30; ++run) {
        std::filesystem::remove_all(frames_);
        const std::uint64_t first = run % 3 == 0 ? 0 : 50 + random() % 150;
        Progress progress;
        const pid_t child = in_child([&] {
            pictures::PictureStore store{frames_, "top", 64};
            for (std::uint64_t n = 1;; ++n) {
                store.add(numbered(n, shape_));
                progress.set(n);
            }
        });
        EXPECT_TRUE(progress.reached(first, child));
        std::this_thread::sleep_for(std::chrono::microseconds{random() % 20'000});
        ASSERT_EQ(::kill(child, SIGKILL), 0);
        ASSERT_EQ(::waitpid(child, nullptr, 0), child);
        if (pictures::segment_files(frames_, "top").empty()) continue;
        const pictures::PictureCheck check = pictures::finish_frames(frames_, "top");
        EXPECT_EQ(check.whole.size(), check.last);
        EXPECT_LT(progress.now(), check.last + pictures::PictureSegment::block);
        EXPECT_LE(check.bad.size(), pictures::PictureSegment::block);
        for (const pictures::BadPicture& b : check.bad) EXPECT_GT(b.number, check.last);
        expect_whole_but({}, check.last);
        EXPECT_TRUE(pictures::unfinished_files(frames_, "top").empty());
        stored += check.last;
    }
    EXPECT_GT(stored, 1000U) << "nothing was tried";
}

TEST_F(FrameCrashTest, AFlippedBitInAPictureOrARecordIsFoundAndNamed) {
    std::mt19937 random{5};
    for (int run = 0; run < 40; ++run) {
        store_all(40, 16);
        const std::uint64_t number = 1 + random() % 40, place = (number - 1) % 16;
        const pictures::FoundSegment s = segment(static_cast<int>((number - 1) / 16));
        const bool in_record = run % 2 == 0;
        const std::uint64_t at = in_record ? record_at(s, place) + random() % sizeof(pictures::PictureRecord)
                                           : pixels_at(s, place) + random() % shape_.bytes();
        const auto bit = static_cast<char>(1U << random() % 8);
        change(s.file, at, [bit](char& byte) { byte = static_cast<char>(byte ^ bit); });

        const pictures::PictureCheck check = pictures::verify_frames(frames_, "top");
        EXPECT_EQ(check.whole.size(), 39);
        EXPECT_EQ(check.last, number == 40 ? 39 : 40);
        ASSERT_EQ(check.bad.size(), 1);
        EXPECT_EQ(check.bad[0].number, number);
        EXPECT_EQ(check.bad[0].file, s.file);
        EXPECT_EQ(check.bad[0].fault,
                  in_record ? pictures::PictureFault::bad_record : pictures::PictureFault::bad_pixels);
        pictures::PictureReader reader{frames_, "top"};
        expect_in(
            refusal([&] { reader.read(number - 1); }),
            {s.file.string(), "picture " + std::to_string(number) + " ", in_record ? "record" : "pixels"});
        expect_whole_but({number}, 40);
        pictures::finish_frames(frames_, "top");
        expect_whole_but({number}, check.last);
    }
}

// After a power cut, records may be on the disk without their pixels, or pixels without records.
TEST_F(FrameCrashTest, ReportsLostRecordBetweenPictures) {
    store_all(40, 16);
    const pictures::FoundSegment s = segment(1);
    for (std::uint64_t i = 0; i < sizeof(pictures::PictureRecord); ++i)
        change(s.file, record_at(s, 3) + i, [](char& byte) { byte = 0; });
    const pictures::PictureCheck check = pictures::finish_frames(frames_, "top");
    ASSERT_EQ(check.bad.size(), 1);
    EXPECT_EQ(check.bad[0].number, 20);
    EXPECT_EQ(check.bad[0].fault, pictures::PictureFault::no_record);
    expect_whole_but({20}, 40);
}

TEST_F(FrameCrashTest, BadPicturesAtTheEndAreCutOff) {
    store_all(40, 16);
    for (const std::uint64_t place : {5U, 6U, 7U}) {
        const pictures::FoundSegment s = segment(2);
        change(s.file, pixels_at(s, place), [](char& byte) { byte = static_cast<char>(byte ^ 1); });
    }
    const pictures::PictureCheck check = pictures::finish_frames(frames_, "top");
    EXPECT_EQ(check.last, 37);
    EXPECT_EQ(check.bad.size(), 3);
    EXPECT_EQ(segment(2).info.places, 5);
    expect_whole_but({}, 37);
    EXPECT_TRUE(pictures::verify_frames(frames_, "top").bad.empty());
}

// A record of another picture does not validate the pixels at its place.
TEST_F(FrameCrashTest, RejectsRecordOfAnotherPicture) {
    store_all(16, 16);
    const pictures::FoundSegment s = segment(0);
    const std::string bytes = bytes_of(s.file);
    for (std::uint64_t i = 0; i < sizeof(pictures::PictureRecord); ++i)
        change(s.file, record_at(s, 3) + i, [&](char& byte) { byte = bytes[record_at(s, 4) + i]; });
    const pictures::PictureCheck check = pictures::verify_frames(frames_, "top");
    ASSERT_EQ(check.bad.size(), 1);
    EXPECT_EQ(check.bad[0].number, 4);
    EXPECT_EQ(check.bad[0].fault, pictures::PictureFault::bad_record);
}

TEST_F(FrameCrashTest, ALostFileInTheMiddleLeavesTheOthersReadable) {
    store_all(60, 16);
    std::filesystem::remove(segment(1).file);
    std::ofstream{pictures::segment_file(frames_, "top", 2), std::ios::trunc} << "not a segment";
    std::vector<std::uint64_t> lost;
    for (std::uint64_t n = 17; n <= 48; ++n) lost.push_back(n);
    expect_whole_but(lost, 60);
    const pictures::PictureCheck check = pictures::finish_frames(frames_, "top");
    EXPECT_EQ(check.whole.size(), 28);
    EXPECT_EQ(check.last, 60);
    ASSERT_EQ(check.damaged.size(), 2);
    expect_in(check.damaged[0], {"top-0002.h5", "not an HDF5 file"});
    EXPECT_EQ(check.damaged[1], "pictures 17 to 48 are in no readable file");
    expect_whole_but(lost, 60);
    EXPECT_EQ(bytes_of(pictures::segment_file(frames_, "top", 2)), "not a segment")
        << "what cannot be read stays";
}

}  // namespace
}  // namespace shaker::recorded
