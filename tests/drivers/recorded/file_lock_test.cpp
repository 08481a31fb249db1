// Locks on files, and names that replace nothing.
#include "drivers/recorded/h5/file_lock.hpp"

#include <gtest/gtest.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <barrier>
#include <cerrno>
#include <csignal>
#include <fstream>
#include <functional>
#include <future>

#include "drivers/recorded/h5/disk_file.hpp"
#include "drivers/recorded/h5/image.hpp"
#include "tests/support/missing_calls.hpp"
#include "tests/support/recording/recording_folder.hpp"

namespace shaker::h5 {
namespace {

using test::expect_in;
using test::refusal;

class FileLockTest : public testing::Test {
protected:
    test::SessionFolder folder_;
    std::filesystem::path file_ = folder_.write("run.nxs.part", "data");
};

// Exit status of `work` in a process of its own; 1 for an exception.
int status_of(const std::function<void()>& work) {
    const pid_t child = ::fork();
    if (child == 0) {
        try {
            work();
        } catch (const std::exception&) {
            ::_exit(1);
        }
        ::_exit(0);
    }
    int status = -1;
    ::waitpid(child, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

// HDF5 is set up at the first file of a process. Each child is a process whose first two files are opened by
// two threads at once, as those of two cameras at the end of a recording.
TEST_F(FileLockTest, TwoThreadsOpenTheFirstFilesOfAProcess) {
    const std::filesystem::path file = file_.parent_path() / "first.h5";
    ASSERT_EQ(status_of([&] {
                  const Image image;
                  replace_file(file, image.head(image.size()));
              }),
              0);
    for (int i = 0; i < 60; ++i)
        ASSERT_EQ(status_of([&] {
                      std::barrier both{2};
                      const auto open = [&] {
                          both.arrive_and_wait();
                          open_file(file);
                      };
                      auto beside = std::async(std::launch::async, open);
                      open();
                      beside.get();
                  }),
                  0)
            << "process " << i;
}

TEST_F(FileLockTest, SecondOneIsRefusedAndSeesTheProcess) {
    EXPECT_FALSE(locked_by(file_));
    {
        const auto lock = FileLock::take(file_);
        ASSERT_TRUE(lock);
        EXPECT_TRUE(lock->held());
        EXPECT_FALSE(FileLock::take(file_));
        EXPECT_EQ(locked_by(file_), ::getpid());
    }
    EXPECT_FALSE(locked_by(file_));
    EXPECT_TRUE(FileLock::take(file_));
}

TEST_F(FileLockTest, LockDiesWithItsProcess) {
    const pid_t child = ::fork();
    if (child == 0) {
        const auto lock = FileLock::take(file_);
        while (lock) ::pause();
        ::_exit(1);
    }
    while (!locked_by(file_)) ::usleep(1000);
    EXPECT_EQ(locked_by(file_), child);
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
    EXPECT_TRUE(FileLock::take(file_));
}

TEST_F(FileLockTest, NewFileIsLockedAndReplacesNothing) {
    const auto lock = FileLock::of_new(folder_ / "new.nxs.part");
    EXPECT_TRUE(lock.held());
    EXPECT_EQ(locked_by(folder_ / "new.nxs.part"), ::getpid());
    expect_in(refusal([&] { FileLock::of_new(file_); }), {"run.nxs.part", "exists already"});
    EXPECT_EQ(std::filesystem::file_size(file_), 4U);
}

TEST_F(FileLockTest, KnowsThatItsFileWasRenamed) {
    const auto lock = FileLock::take(file_);
    ASSERT_TRUE(lock);
    EXPECT_TRUE(lock->is_still(file_));
    std::filesystem::rename(file_, folder_ / "run.nxs");
    EXPECT_FALSE(lock->is_still(file_));
    EXPECT_TRUE(lock->is_still(folder_ / "run.nxs"));
}

TEST_F(FileLockTest, MissingFileIsNotLocked) {
    EXPECT_FALSE(locked_by(folder_ / "none"));
    EXPECT_THROW(FileLock::take(folder_ / "none"), InputError);
    EXPECT_THROW(FileLock::take(folder_ / "no" / "none", true), DeviceError);
}

TEST_F(FileLockTest, RenameReplacesNothing) {
    const auto taken = folder_.write("run.nxs", "another");
    expect_in(refusal([&] { rename_new(file_, taken); }), {"run.nxs.part", "run.nxs: another file"});
    EXPECT_EQ(std::filesystem::file_size(file_), 4U);
    EXPECT_EQ(std::filesystem::file_size(taken), 7U);
    std::filesystem::remove(taken);
    rename_new(file_, taken);
    EXPECT_FALSE(std::filesystem::exists(file_));
    EXPECT_EQ(std::filesystem::file_size(taken), 4U);
    EXPECT_THROW(rename_new(file_, taken), DeviceError) << "the file is gone";
}

// Some file systems do not know how to rename without replacing.
TEST_F(FileLockTest, FolderIsRenamedInStepsAndReplacesNothing) {
    const auto from = folder_ / "made", to = folder_ / "run.frames";
    std::filesystem::create_directories(from);
    std::ofstream{from / "picture"} << "data";
    test::without_call(SYS_renameat2, EINVAL, [&] {
        std::filesystem::create_directories(to);
        expect_in(refusal([&] { rename_new(from, to); }), {"made", "run.frames: another file"});
        EXPECT_TRUE(std::filesystem::exists(from / "picture"));
        std::filesystem::remove(to);
        rename_new(from, to);
        rename_new(file_, folder_ / "run.nxs");
    });
    EXPECT_TRUE(std::filesystem::exists(to / "picture"));
    EXPECT_FALSE(std::filesystem::exists(from));
    EXPECT_TRUE(std::filesystem::exists(folder_ / "run.nxs"));
}

}  // namespace
}  // namespace shaker::h5
