// Files that are made for a confined child.
#include "daemon/sandbox/new_files.hpp"

#include <gtest/gtest.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <fstream>

#include "drivers/errors.hpp"
#include "tests/support/missing_calls.hpp"
#include "tests/support/program.hpp"

namespace shaker::sandbox {
namespace {

namespace fs = std::filesystem;

void put(const fs::path& file, const std::string& text = "x") { std::ofstream{file} << text; }

TEST(NewFilesTest, EmptyFolderIsRemovedAgain) {
    const fs::path here = test::fresh_folder(), folder = here / "run.export";
    { const NewFolder none{here / "run.nxs", folder}; }
    EXPECT_FALSE(fs::exists(folder));
    put(here / "run.nxs");
    {
        const NewFolder made{here / "run.nxs", folder};
        EXPECT_TRUE(fs::is_directory(folder));
    }
    EXPECT_FALSE(fs::exists(folder));
    {
        const NewFolder made{here / "run.nxs", folder};
        put(folder / "table.csv");
    }
    EXPECT_TRUE(fs::exists(folder / "table.csv"));
    fs::remove(folder / "table.csv");
    { const NewFolder there{here / "run.nxs", folder}; }
    EXPECT_TRUE(fs::exists(folder)) << "it existed before";
}

TEST(NewFilesTest, EmptyFileIsRemovedAgain) {
    const fs::path here = test::fresh_folder(), file = here / "tracks.csv";
    {
        const NewFile made{file};
        EXPECT_TRUE(fs::exists(file));
    }
    EXPECT_FALSE(fs::exists(file));
    {
        const NewFile made{file};
        EXPECT_EQ(write(made.descriptor(), "x", 1), 1);
    }
    EXPECT_EQ(fs::file_size(file), 1U);
}

TEST(NewFilesTest, FileReplacesNothingAndFollowsNoLink) {
    const fs::path here = test::fresh_folder();
    put(here / "there", "");
    fs::create_symlink("victim", here / "link");
    for (const char* name : {"there", "link"}) EXPECT_THROW(NewFile{here / name}, InputError) << name;
    EXPECT_THROW(NewFile{here / "none" / "file"}, DeviceError);
    EXPECT_TRUE(fs::exists(here / "there")) << "it existed before";
    EXPECT_FALSE(fs::exists(here / "victim"));
}

TEST(NewFilesTest, RecordingIsMovedWhenItIsComplete) {
    const fs::path here = test::fresh_folder();
    {
        NewRecording made{here / "run.nxs"};
        EXPECT_EQ(made.working(), here / "run.nxs.unfinished" / "run.nxs");
        EXPECT_THROW(NewRecording{here / "run.nxs"}, InputError);
        put(made.working());
        put(made.folder() / "other");
        fs::create_directories(made.folder() / "run.frames");
        made.keep();
    }
    EXPECT_TRUE(fs::exists(here / "run.nxs"));
    EXPECT_TRUE(fs::exists(here / "run.frames"));
    EXPECT_EQ(std::distance(fs::directory_iterator{here}, {}), 2);
}

TEST(NewFilesTest, RecordingWithoutItsNameStaysInFolder) {
    const fs::path here = test::fresh_folder();
    {
        NewRecording made{here / "run.nxs"};
        put(made.working());
        fs::create_directories(made.folder() / "run.frames");
        put(here / "run.nxs", "another");
        try {
            made.keep();
            FAIL() << "nothing was thrown";
        } catch (const DeviceError& e) {
            EXPECT_NE(std::string{e.what()}.find("move it out of " + made.folder().string()),
                      std::string::npos)
                << e.what();
        }
    }
    EXPECT_EQ(fs::file_size(here / "run.nxs"), 7U);
    EXPECT_TRUE(fs::exists(here / "run.nxs.unfinished" / "run.nxs"));
    EXPECT_TRUE(fs::exists(here / "run.nxs.unfinished" / "run.frames"));
    EXPECT_FALSE(fs::exists(here / "run.frames"));
}

TEST(NewFilesTest, RecordingIsForItsUserOnly) {
    const NewRecording made{test::fresh_folder() / "run.nxs"};
    EXPECT_EQ(fs::status(made.folder()).permissions(), fs::perms::owner_all);
}

// Some file systems do not know how to rename without replacing.
TEST(NewFilesTest, RecordingIsMovedOnEveryFileSystem) {
    const fs::path here = test::fresh_folder();
    test::without_call(SYS_renameat2, EINVAL, [&] {
        NewRecording made{here / "run.nxs"};
        put(made.working());
        fs::create_directories(made.folder() / "run.frames");
        put(made.folder() / "run.frames" / "top-0000.h5");
        made.keep();
    });
    EXPECT_TRUE(fs::exists(here / "run.nxs"));
    EXPECT_TRUE(fs::exists(here / "run.frames" / "top-0000.h5"));
    EXPECT_EQ(std::distance(fs::directory_iterator{here}, {}), 2);
}

}  // namespace
}  // namespace shaker::sandbox
