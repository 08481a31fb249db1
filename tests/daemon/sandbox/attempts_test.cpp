// A confined child and the files of its user.
#include "tests/support/sandbox/attempts.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>

#include "tests/support/missing_calls.hpp"

namespace shaker::sandbox {
namespace {

namespace fs = std::filesystem;
using test::Attempt;
using test::Call;
using test::died;
using test::opened;
using test::outcome_of;
using test::word;

class FileAttemptsTest : public test::AttemptsTest {
protected:
    std::string parent_ = "/proc/" + std::to_string(getpid());

    /// Both kinds can do this.
    void expect_allowed(const char* name, const Call& call) const {
        for (const bool writer : {false, true})
            EXPECT_EQ(word(outcome_of(rights(writer), call)), "SUCCEEDED") << name;
    }

    void expect_own_files() const {
        expect_allowed("read the recording", [&] { return opened(recording_, O_RDONLY); });
        expect_allowed("read its pictures",
                       [&] { return opened(own_ / "run.frames" / "top-0000.h5", O_RDONLY); });
        expect_allowed("list its pictures",
                       [&] { return opened(own_ / "run.frames", O_RDONLY | O_DIRECTORY); });
        expect_allowed("read a library", [] { return opened("/usr/lib/os-release", O_RDONLY); });
        expect_allowed("read its own state", [] { return opened("/proc/self/status", O_RDONLY); });
        const fs::path file = out_ / "a.csv", renamed = out_ / "b.csv";
        const Call write_there = [&] {
            if (::close(opened(file, O_WRONLY | O_CREAT)) < 0 || ::mkdir((out_ / "c").c_str(), 0700) < 0)
                return -1;
            if (::rename(file.c_str(), renamed.c_str()) < 0 || ::rmdir((out_ / "c").c_str()) < 0) return -1;
            return opened(renamed, O_RDWR | O_TRUNC) < 0 ? -1 : ::unlink(renamed.c_str());
        };
        EXPECT_EQ(word(outcome_of(rights(true), write_there)), "SUCCEEDED");
        EXPECT_EQ(word(outcome_of(rights(false), write_there)), "EBADF");
    }

    [[nodiscard]] std::vector<Attempt> on_files() const {
        const fs::path fresh = home_ / "fresh", inside = out_ / "inside";
        return {
            {"read a file of the user", [=, this] { return opened(secret_, O_RDONLY); }, EACCES},
            {"read it by another way", [=, this] { return opened(own_ / ".." / "secret", O_RDONLY); },
             EACCES},
            {"read it through its own root",
             [=, this] { return opened("/proc/self/root" + secret_.string(), O_RDONLY); }, EACCES},
            {"read it through a link among the pictures",
             [=, this] { return opened(own_ / "run.frames" / "link", O_RDONLY); }, EACCES},
            {"read it from an open folder",
             [=, this] {
                 const int folder = opened(own_ / "run.frames", O_RDONLY | O_DIRECTORY);
                 return openat(folder, "../../secret", O_RDONLY);
             },
             EACCES},
            {"write the recording through its descriptor",
             [=, this] {
                 const int file = opened(recording_, O_RDONLY);
                 return opened("/proc/self/fd/" + std::to_string(file), O_RDWR);
             },
             EACCES},
            {"read the system's users", [] { return opened("/etc/passwd", O_RDONLY); }, EACCES},
            {"read a device", [] { return opened("/dev/zero", O_RDONLY); }, EACCES},
            {"list the user's files", [=, this] { return opened(home_, O_RDONLY | O_DIRECTORY); }, EACCES},
            {"read the parent's memory", [=, this] { return opened(parent_ + "/mem", O_RDONLY); }, EACCES},
            {"write the parent's memory", [=, this] { return opened(parent_ + "/mem", O_RDWR); }, EACCES},
            {"read the parent's map", [=, this] { return opened(parent_ + "/maps", O_RDONLY); }, EACCES},
            {"read the parent's environment", [=, this] { return opened(parent_ + "/environ", O_RDONLY); },
             EACCES},
            {"list the parent's open files", [=, this] { return opened(parent_ + "/fd", O_RDONLY); }, EACCES},
            {"write a file of the user", [=, this] { return opened(secret_, O_WRONLY); }, EACCES},
            {"empty a file of the user", [=, this] { return opened(secret_, O_RDONLY | O_TRUNC); }, EACCES},
            {"create a file beside", [=] { return opened(fresh, O_WRONLY | O_CREAT); }, EACCES},
            {"create a file that has no name", [=, this] { return opened(home_, O_RDWR | O_TMPFILE); },
             EACCES},
            {"write the recording", [=, this] { return opened(recording_, O_RDWR); }, EACCES},
            {"write its own settings", [] { return opened("/proc/self/oom_score_adj", O_WRONLY); }, EACCES},
            {"creat()", [=] { return creat(fresh.c_str(), 0600); }, died, EACCES},
            {"remove a file of the user", [=, this] { return unlink(secret_.c_str()); }, died, EACCES},
            {"fetch a file by a new name", [=, this] { return rename(secret_.c_str(), inside.c_str()); },
             died, EACCES},
            {"replace a file of the user",
             [=, this] {
                 close(opened(inside, O_WRONLY | O_CREAT));
                 const int answer = rename(inside.c_str(), secret_.c_str());
                 const int why = errno;
                 unlink(inside.c_str());
                 errno = why;
                 return answer;
             },
             died, EACCES},
            {"name a file of the user again", [=, this] { return link(secret_.c_str(), inside.c_str()); },
             died, EXDEV},
            {"name it beside", [=, this] { return link(secret_.c_str(), fresh.c_str()); }, died, EACCES},
            {"make a folder beside", [=] { return mkdir(fresh.c_str(), 0700); }, died, EACCES},
            {"remove the recording's folder", [=, this] { return rmdir((own_ / "run.frames").c_str()); },
             died, EACCES},
        };
    }
};

TEST_F(FileAttemptsTest, FilesOfOthersStayClosed) {
    if (!test::has_landlock()) GTEST_SKIP() << "this kernel has no Landlock";
    expect_refused(on_files());
}

TEST_F(FileAttemptsTest, OwnFilesAreOpened) { expect_own_files(); }

TEST_F(FileAttemptsTest, OneFileIsWrittenAndNoOther) {
    if (!test::has_landlock()) GTEST_SKIP() << "this kernel has no Landlock";
    Confinement allowed = rights(false);
    allowed.files.writes = {recording_};
    EXPECT_EQ(word(outcome_of(allowed, [&] { return opened(recording_, O_WRONLY | O_TRUNC); })), "SUCCEEDED");
    EXPECT_EQ(word(outcome_of(allowed, [&] { return opened(own_ / "new", O_WRONLY | O_CREAT); })), "EACCES");
    EXPECT_EQ(word(outcome_of(allowed, [&] { return unlink(recording_.c_str()); })), "EACCES");
}

TEST_F(FileAttemptsTest, FolderIsListedAndItsFilesStayClosed) {
    if (!test::has_landlock()) GTEST_SKIP() << "this kernel has no Landlock";
    Confinement allowed = rights(false);
    allowed.files.lists = {home_};
    EXPECT_EQ(word(outcome_of(allowed, [&] { return opened(home_, O_RDONLY | O_DIRECTORY); })), "SUCCEEDED");
    EXPECT_EQ(word(outcome_of(allowed, [&] { return opened(secret_, O_RDONLY); })), "EACCES");
}

TEST_F(FileAttemptsTest, ListOfCallsHoldsWithoutLandlock) {
    test::without_landlock([&] {
        expect_own_files();
        const Attempt attempts[] = {
            {"write a file of the user", [&] { return opened(secret_, O_WRONLY); }, EACCES, test::succeeded},
            {"empty it", [&] { return opened(secret_, O_RDONLY | O_TRUNC); }, EACCES},
            {"remove the pictures", [&] { return unlink((own_ / "run.frames" / "x").c_str()); }, died,
             ENOENT},
            {"change its rights", [&] { return chmod(secret_.c_str(), 0777); }, died},
            {"talk to others", [] { return socket(AF_UNIX, SOCK_STREAM, 0); }, died}};
        expect_refused({std::begin(attempts), std::end(attempts)});
    });
}

}  // namespace
}  // namespace shaker::sandbox
