// The commands that read files of others, as programs: what an attacker in them reaches, with every kernel.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <fstream>
#include <functional>
#include <map>
#include <set>
#include <sstream>
#include <thread>

#include "drivers/recorded/h5/file_lock.hpp"
#include "tests/support/environment.hpp"
#include "tests/support/missing_calls.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/program.hpp"

namespace shaker::commands {
namespace {

namespace fs = std::filesystem;
using test::Outcome;
using test::shakerd;

constexpr std::array commands{"replay run.nxs",
                              "replay --json run.nxs",
                              "recover run.nxs",
                              "recover cut.nxs.part",
                              "export run.nxs",
                              "track lab/session.toml",
                              "track lab/session.toml -o tracks.csv",
                              "track --init lab/top.mkv -o mine.toml",
                              "track --preview lab.jpg lab/session.toml",
                              "reduce lab/session.toml",
                              "reduce --json lab/session.toml -o new.nxs"};

std::string content(const fs::path& file) {
    std::ostringstream text;
    text << std::ifstream{file, std::ios::binary}.rdbuf();
    return text.str();
}

/// A folder with a recording, one without an end, and a session.
class ConfinedCommandsTest : public testing::Test {
protected:
    static void SetUpTestSuite() {
        inputs_ = fs::path{testing::TempDir()} / "shakerd-confined-commands";
        fs::remove_all(inputs_);
        fs::create_directories(inputs_);
        shakerd("run --gamma 0.5g --phi 90deg --periods 4 --frames region -o run.nxs --scene '" +
                    test::source_dir() + "/tests/support/slow_cameras.toml'",
                inputs_);
        shakerd("example lab", inputs_);
        fs::copy_file(inputs_ / "run.nxs", inputs_ / "cut.nxs.part");
        fs::copy(inputs_ / "run.frames", inputs_ / "cut.frames");
    }
    static void TearDownTestSuite() { fs::remove_all(inputs_); }

    /// A copy of the inputs.
    [[nodiscard]] fs::path fresh_inputs(const std::string& name) const {
        fs::copy(inputs_, folder_ / name, fs::copy_options::recursive);
        return folder_ / name;
    }

    /// Every command in its own copy: what it printed and wrote.
    [[nodiscard]] std::map<std::string, std::string> results(const std::string& kernel) const {
        std::map<std::string, std::string> all;
        for (const std::string command : commands) {
            const fs::path here = fresh_inputs(kernel);
            const Outcome o = shakerd(command, here);
            std::string& seen = all[command];
            seen = std::to_string(o.status) + "\n" + o.out + o.err;
            std::set<fs::path> files;  // a folder lists them in the order in which threads made them
            for (const auto& entry : fs::recursive_directory_iterator{here}) files.insert(entry.path());
            for (const fs::path& file : files)
                if (file.extension() == ".csv")
                    seen += file.filename().string() + content(file);
                else
                    seen += fs::relative(file, here).string() + "\n";
            fs::remove_all(here);
        }
        return all;
    }

    static inline fs::path inputs_;
    fs::path folder_ = test::fresh_folder();
};

TEST_F(ConfinedCommandsTest, AttackerReachesNoOtherFile) {
    if (SHAKER_SANITIZED) GTEST_SKIP() << "sanitisers do not allow a preloaded library";
    if (!test::has_landlock()) GTEST_SKIP() << "this kernel has no Landlock";
    std::ofstream{folder_ / "secret"} << "private";
    const test::Environment attacked{
        {{"LD_PRELOAD", test::build_dir() + "/preload_intruder.so"},
         {"SHAKER_INTRUDER_READ", (folder_ / "secret").string()},
         {"SHAKER_INTRUDER_WRITE", (folder_ / "attacked" / "written").string()}}};
    for (const std::string command : commands) {
        const fs::path here = fresh_inputs("attacked");
        const Outcome o = shakerd(command, here);
        EXPECT_EQ(o.status, 0) << command << "\n" << o.err;
        const auto at = o.err.find("intruder: ");
        ASSERT_NE(at, std::string::npos) << command << "\n" << o.err;
        EXPECT_EQ(o.err.substr(at, o.err.find('\n', at) - at), "intruder: read 13, write 13") << command;
        EXPECT_EQ(o.err.find("intruder: ", at + 1), std::string::npos) << command << "\n" << o.err;
        EXPECT_FALSE(fs::exists(here / "written")) << command;
        fs::remove_all(here);
    }
}

/// `text` without its lines with `words`.
std::string without_lines(const std::string& text, const char* words, int& taken) {
    std::istringstream lines{text};
    std::string rest;
    for (std::string line; std::getline(lines, line);)
        if (line.find(words) == std::string::npos)
            rest += line + "\n";
        else
            ++taken;
    return rest;
}

TEST_F(ConfinedCommandsTest, ResultsAreEqualWithoutLandlock) {
    const char* warning = "cannot restrict a file reader to its files";
    decltype(results("")) with = results("a kernel"), without;
    test::without_landlock([&] { without = results("a kernel"); });
    for (const auto& [command, seen] : with) {
        EXPECT_EQ(seen.substr(0, 2), "0\n") << command << "\n" << seen;
        int warned = 0, ignored = 0;
        EXPECT_EQ(without_lines(without.at(command), warning, warned), without_lines(seen, warning, ignored))
            << command;
        EXPECT_EQ(warned, 1) << command << "\n" << without.at(command);
    }
}

TEST_F(ConfinedCommandsTest, UserWithoutPrivilegesReadsAndWrites) {
    if (getuid() != 0) GTEST_SKIP() << "the tests run as this user already";
    constexpr uid_t nobody = 65534;
    fs::permissions(folder_, fs::perms::all);
    bool reached = false;
    std::thread{[&] {  // the kernel's own calls change this thread alone
        syscall(SYS_setresgid, nobody, nobody, nobody);
        syscall(SYS_setresuid, nobody, nobody, nobody);
        reached = access((test::build_dir() + "/shakerd").c_str(), X_OK) == 0;
        if (!reached) return;
        for (const auto& [command, seen] : results("a home"))
            EXPECT_EQ(seen.substr(0, 2), "0\n") << command << "\n" << seen;
    }}
        .join();
    if (!reached) GTEST_SKIP() << "another user cannot reach the programs of this build";
}

TEST_F(ConfinedCommandsTest, FailedCommandLeavesNothing) {
    std::ofstream{folder_ / "bad.nxs"} << "not HDF5";
    std::ofstream{folder_ / "bad.toml"} << "title = \"no camera\"\n";
    for (const char* command : {"export bad.nxs", "export none.nxs", "track bad.toml -o t.csv",
                                "reduce bad.toml -o r.nxs", "reduce none.toml -o r.nxs"})
        EXPECT_EQ(shakerd(command, folder_).status, 2) << command;
    EXPECT_EQ(std::distance(fs::directory_iterator{folder_}, {}), 2);
}

TEST_F(ConfinedCommandsTest, TracksReplaceNoFileAndFollowNoLink) {
    const fs::path here = fresh_inputs("linked");
    std::ofstream{here / "victim"} << "mine";
    fs::create_symlink("victim", here / "tracks.csv");
    for (const char* name : {"tracks.csv", "victim"}) {
        const Outcome o = shakerd(std::string{"track lab/session.toml -o "} + name, here);
        EXPECT_EQ(o.status, 2) << name;
        EXPECT_NE(o.err.find(std::string{name} + ": exists already"), std::string::npos) << o.err;
        EXPECT_EQ(content(here / "victim"), "mine") << name;
    }
}

TEST_F(ConfinedCommandsTest, RecordingThatIsBeingReducedIsKept) {
    const fs::path here = fresh_inputs("twice");
    fs::create_directories(here / "new.nxs.unfinished");
    const auto other = h5::FileLock::take_folder(here / "new.nxs.unfinished", h5::Sharing::alone);
    const Outcome o = shakerd("reduce lab/session.toml -o new.nxs", here);
    EXPECT_EQ(o.status, 2);
    EXPECT_NE(o.err.find("new.nxs.unfinished: exists"), std::string::npos) << o.err;
    EXPECT_TRUE(fs::exists(here / "new.nxs.unfinished"));
}

// A killed program has left the folder: nobody is needed to remove it.
TEST_F(ConfinedCommandsTest, RecordingThatAKilledProgramLeftIsMadeAgain) {
    const fs::path here = fresh_inputs("left");
    fs::create_directories(here / "new.nxs.unfinished" / "new.frames");
    std::ofstream{here / "new.nxs.unfinished" / "new.nxs"} << "half";
    const Outcome o = shakerd("reduce lab/session.toml -o new.nxs", here);
    EXPECT_EQ(o.status, 0) << o.err;
    EXPECT_TRUE(fs::exists(here / "new.nxs"));
    EXPECT_FALSE(fs::exists(here / "new.nxs.unfinished"));
}

TEST_F(ConfinedCommandsTest, SessionMayNameImagesElsewhere) {
    fs::create_directories(folder_ / "pictures");
    fs::create_directories(folder_ / "session");
    for (const char* number : {"1", "2"})
        std::ofstream{folder_ / "pictures" / (std::string{number} + ".pgm")} << "P5 8 8 255\n"
                                                                             << std::string(64, 'a');
    for (const char* file : {"../pictures", "../pictures/%d.pgm"}) {
        std::ofstream{folder_ / "session" / "session.toml"}
            << "title = \"pictures\"\n[[camera]]\nname = \"top\"\nfile = \"" << file
            << "\"\nframe_rate_hz = 20.0\nfirst_exposure_s = 0.0\nmm_per_px = 1.0\nalong = [1.0, "
               "0.0]\n[[camera.target]]\n"
               "name = \"dot1\"\nkind = \"dots\"\ndiameter_mm = 2.0\nroi_px = [0, 0, 8, 8]\npolarity = "
               "\"dark\"\n";
        const Outcome o = shakerd("track session/session.toml", folder_);
        EXPECT_EQ(o.status, 2) << file << o.out;
        EXPECT_NE(o.err.find("grey levels span 97"), std::string::npos) << file << o.err;  // it was decoded
    }
}

}  // namespace
}  // namespace shaker::commands
