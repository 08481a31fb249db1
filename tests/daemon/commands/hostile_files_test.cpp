// Files with control characters in every text: no command prints them.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/support/printed.hpp"
#include "tests/support/program.hpp"

namespace shaker::commands {
namespace {

namespace fs = std::filesystem;
using test::controls_in;
using test::fresh_folder;
using test::Outcome;
using test::shakerd;

/// A short run without pictures, recorded once.
const fs::path& recorded_run() {
    static const fs::path file = [] {
        const fs::path folder = fs::path{testing::TempDir()} / "shakerd-hostile-files";
        fs::remove_all(folder);
        fs::create_directories(folder);
        std::ofstream{folder / "scene.toml"} << "[top]\npositions = 1\nframe_rate_hz = 200\n"
                                                "[side]\npositions = 1\nframe_rate_hz = 200\n";
        shakerd("run --gamma 0.5g --phi 90deg --periods 4 --frames off --scene scene.toml -o run.nxs",
                folder);
        return folder / "run.nxs";
    }();
    return file;
}

constexpr const char* spoil_script = R"(import h5py, shutil, sys
name, each = sys.argv[1], sys.argv[2] == 'each'
evil = bytes.fromhex('1b5b324a9b33316dc29b33326d070d7fffe280ae') * 99
def spoil(item):
    if not item.name.endswith('seals/columns'):
        item[...] = evil[:item.dtype.itemsize]
texts = []
def look(path, item):
    if isinstance(item, h5py.Dataset) and item.dtype.kind == 'S' and item.size > 0:
        texts.append(path)
with h5py.File(name, 'r') as file:
    file.visititems(look)
for n, path in enumerate(texts):
    print(path)
    spoilt = f'{n}.nxs' if each else name
    if each:
        shutil.copy(name, spoilt)
    with h5py.File(spoilt, 'r+') as file:
        spoil(file[path])
)";

enum class Spoil { all, each };
/// Fills the texts of a recording with control characters. Spoil::each: one text in each of the copies 0.nxs,
/// 1.nxs and so on beside it. Returns the paths of the texts.
std::vector<std::string> spoil(const fs::path& file, Spoil which) {
    const fs::path script = file.parent_path() / "spoil.py", list = file.parent_path() / "paths";
    std::ofstream{script} << spoil_script;
    const std::string command = "cd '" + file.parent_path().string() + "' && /usr/bin/python3 spoil.py " +
                                file.filename().string() + (which == Spoil::each ? " each" : " all") + " >'" +
                                list.string() + "'";
    EXPECT_EQ(std::system(command.c_str()), 0) << command;
    std::vector<std::string> paths;
    std::ifstream in{list};
    for (std::string path; std::getline(in, path);) paths.push_back(path);
    return paths;
}

void expect_clean(const std::string& command, const fs::path& folder) {
    const Outcome o = shakerd(command, folder);
    EXPECT_EQ(controls_in(o.out), "") << command << "\n" << o.out;
    EXPECT_EQ(controls_in(o.err), "") << command << "\n" << o.err;
    if (command.find("--json") != std::string::npos && o.status == 0) {
        EXPECT_TRUE(nlohmann::json::accept(o.out)) << o.out;
    }
}

TEST(HostileFilesTest, ControlsAreFoundByThisTest) {
    EXPECT_EQ(controls_in(test::hostile_text), "1b 9b 9b 07 0d 7f ");
    EXPECT_EQ(controls_in("Läufer 2 µm, φ = 90°\n\tмю"), "");
}

TEST(HostileFilesTest, RecordingWithEveryTextSpoilt) {
    const fs::path folder = fresh_folder();
    fs::copy_file(recorded_run(), folder / "run.nxs");
    EXPECT_GE(spoil(folder / "run.nxs", Spoil::all).size(), 20U);
    fs::copy_file(folder / "run.nxs", folder / "cut.nxs.part");
    for (const char* command :
         {"replay run.nxs", "replay --json run.nxs", "replay --set from_s=0.5 run.nxs", "recover run.nxs",
          "recover --json run.nxs", "recover cut.nxs.part", "recover --json cut.nxs.part", "export run.nxs",
          "export --json -o other run.nxs"})
        expect_clean(command, folder);
}

TEST(HostileFilesTest, RecordingWithOneTextSpoilt) {
    const fs::path folder = fresh_folder();
    fs::copy_file(recorded_run(), folder / "whole.nxs");
    int replayed = 0;
    for (const std::string& path : spoil(folder / "whole.nxs", Spoil::each)) {
        SCOPED_TRACE(path);
        expect_clean("replay " + std::to_string(replayed++) + ".nxs", folder);
    }
    EXPECT_GE(replayed, 20);
}

TEST(HostileFilesTest, CampaignWithEveryTextSpoilt) {
    const fs::path folder = fresh_folder();
    std::ofstream{folder / "plan.toml"}
        << "[point]\nperiods = 8\n[[series]]\ngamma = \"0.5g\"\nphi = [0, 1]\n";
    ASSERT_EQ(shakerd("campaign plan.toml --rig sim: -o points", folder).status, 0);
    const Outcome replay = shakerd("replay points/campaign.nxs", folder);
    EXPECT_EQ(replay.status, 2);
    EXPECT_NE(replay.err.find("campaign --reduce"), std::string::npos) << replay.err;
    EXPECT_GE(spoil(folder / "points/campaign.nxs", Spoil::all).size(), 8U);
    for (const char* command :
         {"export points/campaign.nxs", "export --json -o other points/campaign.nxs", "mu points",
          "mu --json points", "report points", "replay points/campaign.nxs", "campaign --reduce points"})
        expect_clean(command, folder);
    std::ofstream{folder / "points/journal.jsonl", std::ios::app} << test::hostile_text << "\n";
    for (const char* command : {"campaign --reduce points", "campaign --continue points", "report points"})
        expect_clean(command, folder);
}

// TOML has escapes for control characters, so its texts can have any.
TEST(HostileFilesTest, SessionWithHostileNames) {
    const fs::path folder = fresh_folder();
    ASSERT_EQ(shakerd("example lab", folder).status, 0);
    std::stringstream whole;
    whole << std::ifstream{folder / "lab/session.toml"}.rdbuf();
    const std::string evil = R"(\u001b[2J\u009b31m\u007f\r\u202e)";
    for (const std::string key :
         {"title = \"", "name = \"", "file = \"", "kind = \"", "time = \"", "axes = [\""}) {
        SCOPED_TRACE(key);
        std::string text = whole.str();
        for (std::size_t at = text.find(key); at != std::string::npos; at = text.find(key, at + 1)) {
            if (text.compare(at, 14, "name = \"walker") == 0 || text.compare(at, 12, "name = \"base\"") == 0)
                continue;
            text.insert(at + key.size(), evil);
        }
        ASSERT_NE(text, whole.str());
        std::ofstream{folder / "lab/hostile.toml"} << text;
        for (const char* command : {"reduce lab/hostile.toml", "reduce --json lab/hostile.toml",
                                    "track lab/hostile.toml", "track --json lab/hostile.toml"})
            expect_clean(command, folder);
    }
}

TEST(HostileFilesTest, SettingsWithHostileKeys) {
    const fs::path folder = fresh_folder();
    std::ofstream{folder / "scene.toml"} << R"("\u001b[2J\u009b31m" = 3)";
    std::ofstream{folder / "broken.toml"} << "a = " << test::hostile_text;
    for (const std::string file : {"scene.toml", "broken.toml", "no\x1b[2J.toml"})
        for (const std::string command : {"run --scene ", "run --rig ", "check --scene ", "predict --scene ",
                                          "serve --settings ", "replay ", "track "})
            expect_clean(command + "'" + file + "'", folder);
}

}  // namespace
}  // namespace shaker::commands
