// Recordings by earlier programs can be opened, replayed to the bit, exported and recovered: three of layout
// 1, and one of layout 6 with its pictures.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>
#include <sstream>

#include "daemon/recording/tables/measured_tables.hpp"
#include "daemon/recording/tables/places.hpp"
#include "drivers/recorded/h5/h5.hpp"
#include "drivers/recorded/recording_file.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/program.hpp"
#include "tests/support/recording/recorded_content.hpp"

namespace shaker::commands {
namespace {

using nlohmann::json;
using test::Outcome;
using test::shakerd;

const std::string golden = test::source_dir() + "/tests/golden/recordings/";

// The name of a kept recording, unpacked in `folder`, with its pictures if it has some.
std::string unpacked(const std::string& name, const std::filesystem::path& folder) {
    const bool pictures = name == "walk.nxs";
    const std::string command =
        pictures ? "tar -xzf '" + golden + "walk.tar.gz' -C '" + folder.string() + "'"
                 : "gzip -dc '" + golden + name + ".gz' > '" + (folder / name).string() + "'";
    EXPECT_EQ(std::system(command.c_str()), 0) << command;
    return name;
}

// v(t), which was smoothed across the ends of slips (FORMAT.md, version 7), its error, and the tilt's share
// of v_D, which follows from it; v_D and D stay. Else only errors whose estimate was wrong (version 4). v_D,
// D and what contains them: by restricted likelihood, because they were 2.5 to 5 times too wide without
// jitter and 4 times too narrow with memory. v_rms: with the error of the frequency. phi: its scatter wraps
// at 180 degrees. Errors of the base's motion (version 11): harmonics beyond the fitted ones do not count as
// noise; the bench check weighs by these errors.
const std::set<std::string> may_move{"results/gamma_errors",
                                     "results/rho_errors",
                                     "harmonics/amplitude_errors",
                                     "harmonics/phase_errors",
                                     "periods/gamma_errors",
                                     "periods/phi_errors",
                                     "bench_check/ratio",
                                     "bench_check/ratio_errors",
                                     "bench_check/second_over_first",
                                     "bench_check/second_over_first_errors",
                                     "bench_check/views/ratio_errors",
                                     "bench_check/views/delay_errors",
                                     "measured/results/efficiency_errors",
                                     "measured/results/gamma_errors",
                                     "measured/results/rho_errors",
                                     "measured/results/phi_errors",
                                     "measured/results/v_rms_errors",
                                     "measured/harmonics/amplitude_errors",
                                     "measured/harmonics/phase_errors",
                                     "measured/periods/gamma_errors",
                                     "measured/periods/phi_errors",
                                     "measured/bench_check/ratio",
                                     "measured/bench_check/ratio_errors",
                                     "measured/bench_check/second_over_first",
                                     "measured/bench_check/second_over_first_errors",
                                     "measured/bench_check/views/ratio_errors",
                                     "measured/bench_check/views/delay_errors",
                                     "results/v_D_errors",
                                     "results/D_errors",
                                     "results/efficiency_errors",
                                     "results/v_rms_errors",
                                     "results/phi_errors",
                                     "periods/D_errors",
                                     "cycle/v",
                                     "cycle/v_errors",
                                     "bench_check/tilt_v_D",
                                     "bench_check/tilt_mu",
                                     "measured/cycle/v",
                                     "measured/cycle/v_errors",
                                     "measured/bench_check/tilt_v_D",
                                     "measured/bench_check/tilt_mu"};

// The results that a replay lists as different; the streams are identical to the bit.
std::set<std::string> moved(const std::string& out) {
    std::istringstream lines{out};
    std::set<std::string> found;
    bool listed = false;
    for (std::string line; std::getline(lines, line);) {
        if (listed && line.starts_with("  ")) found.insert(line.substr(2, line.find_first_of(" :", 2) - 2));
        listed = listed || line.starts_with("replay: the streams are identical to the bit");
    }
    return found;
}

class KeptRecordingTest : public testing::TestWithParam<const char*> {
protected:
    std::filesystem::path folder_ = test::fresh_folder();
};
INSTANTIATE_TEST_SUITE_P(Recordings, KeptRecordingTest,
                         testing::Values("run.nxs", "tripped.nxs", "footage.nxs", "walk.nxs"),
                         [](const auto& name) { return std::filesystem::path{name.param}.stem().string(); });

TEST_P(KeptRecordingTest, Opens) {
    const recorded::RecordingReader file{folder_ / unpacked(GetParam(), folder_)};
    EXPECT_EQ(file.header().schema, std::string{GetParam()} == "walk.nxs" ? 6 : 1);
    EXPECT_EQ(file.header().views.size(), 2U);
    EXPECT_EQ(file.damage(), std::vector<std::string>{});
    EXPECT_EQ(recording::read_finished(file).empty(), file.header().schema == 1);
    EXPECT_NO_THROW(recording::require_known_schema(file));
}

TEST_P(KeptRecordingTest, ReplaysToTheBit) {
    const Outcome o = shakerd("replay " + unpacked(GetParam(), folder_), folder_);
    EXPECT_EQ(o.status, 0) << o.err;
    EXPECT_TRUE(std::ranges::includes(may_move, moved(o.out))) << o.out;
    const bool tripped = std::string{GetParam()} == "tripped.nxs";
    EXPECT_EQ(o.out.find("a limit stopped this run at 3.20") != std::string::npos, tripped) << o.out;
    EXPECT_NE(o.out.find("v_D"), std::string::npos) << o.out;
}

TEST_P(KeptRecordingTest, ExportsAllItsTables) {
    const std::string name = unpacked(GetParam(), folder_);
    const Outcome o = shakerd("export --json -o out " + name, folder_);
    ASSERT_EQ(o.status, 0) << o.err;
    const recorded::RecordingReader file{folder_ / name};
    std::map<std::string, std::size_t> rows;
    const json exported = json::parse(o.out);
    for (const json& t : exported["tables"]) rows[t["table"]] = t["rows"].get<std::size_t>();
    const bool session = file.header().kind == "session", first = file.header().schema == 1;
    for (const char* table :
         {"accelerometer", "clocks", "cycle", "events", "frames/top", "gaps", "harmonics", "identification",
          "measurements", "periods", "pictures/side", "process", "results", "results/notes", "stick",
          "tracks/top/walker", "transverse", "trips"})
        EXPECT_TRUE(rows.contains(table)) << table;
    for (const char* table : {"changes", "plays"}) EXPECT_EQ(rows.contains(table), !session) << table;
    EXPECT_EQ(rows.contains("measured"), !first);
    EXPECT_EQ(rows["results"], 1U);
    EXPECT_EQ(rows["frames/top"], file.frames("top").size());
    EXPECT_EQ(rows["tracks/top/walker"], file.frames("top").size());
    EXPECT_EQ(rows["cycle"], file.numbers("cycle/v").size());
    EXPECT_EQ(rows["trips"], file.texts("trips/cause").size());
}

TEST_P(KeptRecordingTest, IsIntact) {
    const Outcome o = shakerd("recover " + unpacked(GetParam(), folder_), folder_);
    EXPECT_EQ(o.status, 0) << o.err;
    EXPECT_NE(o.out.find("finished recording, intact"), std::string::npos) << o.out;
}

// The pictures are tracked again. Since version 9 pixels beside an outline fade out instead of ending with a
// whole pixel: a disc or a rectangle is found elsewhere by a fraction of what the older program's windows
// made it jump.
TEST(KeptPicturesTest, AreFollowedAgainToWithinTheirErrors) {
    const auto folder = test::fresh_folder();
    unpacked("walk.nxs", folder);
    EXPECT_EQ(test::content_of(folder / "walk.nxs").wrong, std::vector<std::string>{});
    const Outcome o = shakerd("replay --from raw walk.nxs", folder);
    EXPECT_EQ(o.status, 0) << o.err;
    EXPECT_NE(
        o.out.find("because this program follows targets otherwise than the one that recorded the file"),
        std::string::npos)
        << o.out;
    int tracks = 0;
    const std::regex track{
        "replay: track moved, (\\S+): (\\S+) px rms, at most (\\S+) .* another state in (\\d+) of"};
    for (std::sregex_iterator at{o.out.begin(), o.out.end(), track}, end; at != end; ++at, ++tracks) {
        EXPECT_LT(std::stod((*at)[2]), 0.003) << (*at)[1];
        EXPECT_LT(std::stod((*at)[3]), 0.006) << (*at)[1];
        EXPECT_EQ((*at)[4], "0") << (*at)[1];
    }
    EXPECT_GT(tracks, 0) << o.out;
}

TEST(KeptRecordingCrashTest, UnfinishedRecordingIsRecovered) {
    const auto folder = test::fresh_folder();
    unpacked("killed.nxs.part", folder);
    std::filesystem::copy_file(golden + "killed.nxs.journal", folder / "killed.nxs.journal");
    const Outcome o = shakerd("recover killed.nxs.part", folder);
    ASSERT_EQ(o.status, 0) << o.err;
    EXPECT_NE(o.out.find("complete up to 2.000 s: 800 frames"), std::string::npos) << o.out;
    EXPECT_EQ(recorded::RecordingReader{folder / "killed.nxs"}.header().schema, 1);
    const Outcome replay = shakerd("replay killed.nxs", folder);
    EXPECT_EQ(replay.status, 0) << replay.err;
    EXPECT_NE(replay.out.find("replay: identical"), std::string::npos) << replay.out;
}

TEST(LaterVersionTest, IsRefusedWithBothVersions) {
    const auto folder = test::fresh_folder();
    unpacked("run.nxs", folder);
    {
        const h5::Handle file{H5Fopen((folder / "run.nxs").c_str(), H5F_ACC_RDWR, H5P_DEFAULT), "file"};
        h5::set_attribute(h5::open_group(file.get(), "entry/process").get(), "schema", std::int64_t{99});
    }
    for (const char* command : {"replay run.nxs", "export run.nxs"}) {
        const Outcome o = shakerd(command, folder);
        EXPECT_EQ(o.status, 2) << command << o.err;
        EXPECT_NE(o.err.find("layout version 99 is newer than this program, which reads versions up to"),
                  std::string::npos)
            << o.err;
    }
}

}  // namespace
}  // namespace shaker::commands
