// Files that are made for a confined child.
#include "daemon/sandbox/new_files.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "drivers/errors.hpp"
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
        put(file);
    }
    EXPECT_TRUE(fs::exists(file));
    put(file, "");
    { const NewFile there{file}; }
    EXPECT_TRUE(fs::exists(file)) << "it existed before";
    const NewFile none{""};
}

TEST(NewFilesTest, RecordingIsMovedWhenItIsComplete) {
    const fs::path here = test::fresh_folder();
    {
        const NewRecording made{here / "run.nxs"};
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

TEST(NewFilesTest, RecordingReplacesNothing) {
    const fs::path here = test::fresh_folder();
    {
        const NewRecording made{here / "run.nxs"};
        put(made.working());
        put(here / "run.nxs", "another");
        EXPECT_THROW(made.keep(), InputError);
    }
    EXPECT_EQ(fs::file_size(here / "run.nxs"), 7U);
    EXPECT_FALSE(fs::exists(here / "run.nxs.unfinished"));
}

}  // namespace
}  // namespace shaker::sandbox
