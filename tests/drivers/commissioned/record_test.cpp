#include "drivers/commissioned/record.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/program.hpp"

namespace shaker::commissioned {
namespace {

struct RecordTest : testing::Test {
    ~RecordTest() override { std::filesystem::remove_all(folder); }
    const std::filesystem::path folder = test::fresh_folder(), rig = folder / "bench.toml";
    const std::vector<Named> files{{"alsa_config", "pcm.x { type hw }\n# \"'''\"\\ \t\n"},
                                   {"calibration of accelerometer", "a = 1\n"}};
    void expect_missing(const std::string& rig_text, const std::vector<Named>& now,
                        const std::string& words) {
        const std::string why = missing_record(rig, rig_text, now);
        EXPECT_NE(why.find(words), std::string::npos) << why;
        EXPECT_NE(why.find("shakerd check --commission --rig"), std::string::npos) << why;
    }
};

TEST_F(RecordTest, ReadsBackAndCoversEachFile) {
    write_record(rig, {.date = "2026-11-28",
                       .rig_sha256 = rig_hash("rig"),
                       .files = files,
                       .items = {{"ramp \"seen\"", "4 ms"}}});
    const auto read = read_record(rig);
    ASSERT_TRUE(read);
    EXPECT_EQ(read->date, "2026-11-28");
    EXPECT_EQ(read->files, files);
    ASSERT_EQ(read->items.size(), 1U);
    EXPECT_EQ(read->items[0].name, "ramp \"seen\"");
    EXPECT_EQ(missing_record(rig, "rig", files), "");
    expect_missing("rig ", files, "bench.toml has changed since");
    for (std::size_t i = 0; i < files.size(); ++i) {
        std::vector<Named> changed = files;
        changed[i].text += " ";
        expect_missing("rig", changed, "its " + files[i].what + " has changed since");
    }
}

// Records of earlier versions cover the rig file alone.
TEST_F(RecordTest, EarlierRecordHoldsForARigFileThatNamesNoOther) {
    std::ofstream{record_of(rig)} << "date = \"2026-01-01\"\nrig_sha256 = \"" << rig_hash("rig")
                                  << "\"\n\n[[item]]\nname = \"ramp\"\nresult = \"4 ms\"\n";
    EXPECT_EQ(missing_record(rig, "rig", {}), "");
    expect_missing("rig", files, "does not cover its alsa_config, as those of earlier versions");
}

TEST_F(RecordTest, NoRecordAndNoTomlAreNamed) {
    expect_missing("rig", {}, "has not been commissioned: there is no");
    std::ofstream{record_of(rig)} << "date = ";
    expect_missing("rig", {}, "bench.toml.commissioned");
}

}  // namespace
}  // namespace shaker::commissioned
