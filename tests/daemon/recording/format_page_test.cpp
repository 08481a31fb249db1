// FORMAT.md agrees with the code, and a recording agrees with FORMAT.md.
#include "tests/support/recording/format_page.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "daemon/recording/tables/places.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/program.hpp"
#include "tests/support/recording/small_recording.hpp"

namespace shaker::recording {
namespace {

const std::string page_file = test::source_dir() + "/daemon/recording/FORMAT.md";

std::string page() {
    std::ifstream in{page_file};
    std::ostringstream text;
    text << in.rdbuf();
    return text.str();
}

TEST(FormatPageTest, HasTheTablesOfTheCode) {
    test::expect_page("daemon/recording/FORMAT.md",
                      [](const std::string& now) { return test::with_tables(now); });
}

TEST(FormatPageTest, HasTheWrittenVersion) {
    EXPECT_NE(page().find(fmt::format("This page describes version {}.", schema_version)), std::string::npos);
}

TEST(FormatPageTest, EveryGroupAndColumnHasAMeaning) {
    recorded::RecordingHeader header = test::small_header();
    for (const recorded::GroupLayout& g : recording_places(header, true)) {
        EXPECT_NE(g.meaning, "") << g.path;
        std::vector<std::string> names;
        for (const recorded::Place& p : g.places) {
            EXPECT_NE(p.meaning, "") << g.path << "/" << p.name;
            EXPECT_EQ(std::ranges::count(names, p.name), 0) << g.path << "/" << p.name;
            names.push_back(p.name);
        }
    }
}

void check_columns(const recorded::RecordingReader& file, const std::string& group, const std::string& text) {
    for (const std::string& name : file.names(group)) {
        const std::string path = group.empty() ? name : group + "/" + name;
        if (group == "raw" && name != "drive" && name != "accelerometer") continue;  // cameras: as <camera>
        const bool column = text.find("`" + name + "`") != std::string::npos;
        EXPECT_TRUE(column || text.find("/" + name) != std::string::npos) << path;
    }
}

TEST(FormatPageTest, HasEverythingInARecording) {
    const auto file = test::fresh_folder() / "run.nxs";
    recorded::RecordingHeader header = test::small_header();
    lay_out(header, true);
    recorded::RecordingWriter{file, header}.close();
    const recorded::RecordingReader reader{file};
    EXPECT_EQ(reader.header().schema, schema_version);
    const std::string text = page();
    for (const char* group :
         {"process", "results", "raw/drive", "raw/drive/changes", "raw/accelerometer", "raw/top", "measured",
          "measured/results", "seals", "trips", "tracks/top/walker"})
        check_columns(reader, group, text);
}

}  // namespace
}  // namespace shaker::recording
