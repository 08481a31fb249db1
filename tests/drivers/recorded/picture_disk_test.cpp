// Disks that are full, fail or do not support direct writing: reported once, and stored pictures stay
// readable.
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>

#include "drivers/recorded/pictures/picture_check.hpp"
#include "drivers/recorded/pictures/picture_reader.hpp"
#include "drivers/recorded/pictures/picture_store.hpp"
#include "tests/support/recording/many_pictures.hpp"

namespace shaker::recorded {

using namespace test;
namespace {

constexpr pictures::PictureShape shape{256, 128, 2};  // 64 KiB
constexpr std::uint64_t segment = 64;                 // 4 MiB

enum class Disk { tmpfs, ramfs };

/// A private mount name space of this process, as root or as an ordinary user with unchanged id.
bool alone() {
    const auto user = std::to_string(::geteuid()), group = std::to_string(::getegid());
    if (::geteuid() == 0 && ::unshare(CLONE_NEWNS) == 0) return true;
    if (::unshare(CLONE_NEWNS | CLONE_NEWUSER) != 0) return false;
    std::ofstream{"/proc/self/setgroups"} << "deny";
    std::ofstream{"/proc/self/uid_map"} << user << " " << user << " 1";
    std::ofstream{"/proc/self/gid_map"} << group << " " << group << " 1";
    return true;
}

/// A private disk of this process, at `where`.
bool mounted(Disk disk, const std::filesystem::path& where) {
    const auto [kind, options] =
        disk == Disk::tmpfs ? std::pair{"tmpfs", "size=20m,mode=777"} : std::pair{"ramfs", "mode=777"};
    return alone() && ::mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) == 0 &&
           ::mount("none", where.c_str(), kind, 0, options) == 0;
}

/// Adds pictures until the first error: number of accepted pictures, and the error. A second error is not
/// allowed.
struct Filling {
    std::uint64_t taken = 0;
    std::string complaint;
};
Filling fill(pictures::PictureStore& store, std::uint64_t from, std::uint64_t to) {
    Filling f;
    for (std::uint64_t n = from; n <= to; ++n) {
        try {
            const std::uint64_t number = store.add(numbered(n, shape));
            EXPECT_EQ(number, f.complaint.empty() ? n : 0);
            if (number != 0) ++f.taken;
        } catch (const DeviceError& error) {
            EXPECT_TRUE(f.complaint.empty()) << "told twice";
            f.complaint = error.what();
        }
    }
    return f;
}

std::string failure(const std::function<void()>& action) {
    try {
        action();
    } catch (const DeviceError& error) {
        return error.what();
    }
    return "none";
}

class FrameDiskTest : public testing::Test {
protected:
    static constexpr int no_disk = 77;

    /// Runs `body` in a separate process with its own disk and limits.
    template <class Body>
    int exit_status_of(Body body) {
        std::fflush(nullptr);
        const pid_t child = fork();
        if (child == 0) {
            int status = 1;
            try {
                status = body();
            } catch (const std::exception& error) {
                ADD_FAILURE() << error.what();
            }
            std::fflush(nullptr);
            ::_exit(HasFailure() ? 1 : status);
        }
        int status = 0;
        EXPECT_EQ(::waitpid(child, &status, 0), child);
        return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    }
    template <class Body>
    void on_a_disk(Disk disk, Body body) {
        std::filesystem::create_directories(disk_);
        const int status = exit_status_of([&] {
            if (!mounted(disk, disk_)) return no_disk;
            body();
            return 0;
        });
        if (status == no_disk) GTEST_SKIP() << "this system lets nobody mount a disk of his own";
        EXPECT_EQ(status, 0);
    }
    static void expect_readable(const std::filesystem::path& frames, std::uint64_t count) {
        pictures::PictureReader reader{frames, "top"};
        ASSERT_EQ(reader.count(), count);
        for (std::uint64_t n = 1; n <= count; ++n) expect_same(*reader.read(n - 1), numbered(n, shape), n);
    }

    SessionFolder folder_;
    std::filesystem::path disk_ = folder_ / "disk", frames_ = disk_ / "run.frames";
};

TEST_F(FrameDiskTest, RefusesFullDiskBeforeTheStart) {
    on_a_disk(Disk::tmpfs, [&] {
        pictures::PictureStore store{frames_, "top", 8 * segment};
        expect_in(failure([&] { store.prepare(shape); }),
                  {frames_.string(), "33.6 MB required", "21.0 MB free", "No space left on device"});
        EXPECT_TRUE(std::filesystem::is_empty(frames_)) << "something stayed";
        EXPECT_EQ(store.stored(), 0);
    });
}

TEST_F(FrameDiskTest, FullDiskEndsStoringOnly) {
    on_a_disk(Disk::tmpfs, [&] {
        pictures::PictureStore store{frames_, "top", segment};
        store.prepare(shape);
        const Filling filling = fill(store, 1, 1000);
        EXPECT_EQ(filling.taken, 4 * segment);
        expect_in(filling.complaint, {frames_.string(), "top-0004.h5", "4.2 MB required", "No space left"});
        EXPECT_EQ(store.stored(), 4 * segment);
        EXPECT_EQ(failure([&] { store.finish(); }), "none");
        expect_readable(frames_, 4 * segment);
    });
}

// Another program uses the rest of the disk: a segment that cannot be cut, a link that cannot be
// made.
TEST_F(FrameDiskTest, FinishesLaterWhenDiskWasFull) {
    on_a_disk(Disk::tmpfs, [&] {
        pictures::PictureStore store{frames_, "top", segment};
        EXPECT_EQ(fill(store, 1, 100).taken, 100);
        store.sync();
        std::ofstream{disk_ / "other", std::ios::binary} << std::string(std::size_t{30'000'000}, 'x');
        expect_in(failure([&] { store.finish(); }), {frames_.string(), "No space left"});
        expect_readable(frames_, 100);
        std::filesystem::remove(disk_ / "other");
        EXPECT_EQ(failure([&] { store.finish(); }), "none");
        expect_readable(frames_, 100);
        EXPECT_EQ(pictures::find_segment(frames_ / "top-0001.h5", "top").info.places, 100 - segment);
        EXPECT_TRUE(std::filesystem::exists(frames_ / "top.h5"));
        EXPECT_TRUE(pictures::unfinished_files(frames_, "top").empty());
    });
}

TEST_F(FrameDiskTest, WritesThroughCacheWithoutODirect) {
    on_a_disk(Disk::ramfs, [&] {
        pictures::PictureStore store{frames_, "top", segment};
        EXPECT_EQ(fill(store, 1, 150).taken, 150);
        EXPECT_FALSE(store.direct());
        store.finish();
        expect_readable(frames_, 150);
    });
}

// A limit of the file length simulates a disk that fails within a segment.
TEST_F(FrameDiskTest, ReportsDiskFailureOnceAndKeepsPictures) {
    const int status = exit_status_of([&] {
        pictures::PictureStore store{frames_, "top", segment};
        // After these the next segment exists already and the one after it does not.
        EXPECT_EQ(fill(store, 1, segment + 2).taken, segment + 2);
        const rlimit none{4096, 4096};
        EXPECT_EQ(::setrlimit(RLIMIT_FSIZE, &none), 0);
        ::signal(SIGXFSZ, SIG_IGN);
        const Filling filling = fill(store, segment + 3, 1000);
        EXPECT_EQ(filling.taken, 5);
        expect_in(filling.complaint, {"top-0001.h5", "cannot be written", "File too large"});
        EXPECT_EQ(store.stored(), segment);
        return 0;
    });
    ASSERT_EQ(status, 0);
    expect_readable(frames_, segment);
    const pictures::PictureCheck check = pictures::finish_frames(frames_, "top");
    EXPECT_EQ(check.whole.size(), segment);
    EXPECT_TRUE(check.bad.empty());
    expect_readable(frames_, segment);
}

}  // namespace
}  // namespace shaker::recorded
