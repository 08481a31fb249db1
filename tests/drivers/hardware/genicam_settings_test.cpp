#include <gtest/gtest.h>

#include "drivers/errors.hpp"
#include "drivers/hardware/genicam/settings.hpp"
#include "drivers/hardware/genicam/setup.hpp"

extern "C" void arv_enable_interface(const char* interface_id);  // of Aravis; warns of an unknown one

namespace shaker::hardware {
namespace {

genicam::GenicamSettings read(const std::string& text) {
    SettingsTable table = SettingsTable::from_text(text, "bench.toml");
    genicam::GenicamSettings s = genicam::read_genicam_settings(table);
    table.finish();
    return s;
}

std::string refusal(const std::string& text) {
    try {
        read(text);
    } catch (const InputError& error) {
        return error.what();
    }
    return "accepted";
}

TEST(GenicamSettingsTest, EveryKeyIsRead) {
    const genicam::GenicamSettings s = read(R"(
id = "Shaker-Mock-TOP"
region_px = [16, 8, 512, 96]
exposure_s = 0.0005
frame_rate_hz = 200
pixel_format = "Mono12p"
trigger = "free"
trigger_source = "Line2"
packet_bytes = 9000
ptp = true
chunks = true
gain = 3.5
give_up_s = 5
)");
    EXPECT_EQ(s.id, "Shaker-Mock-TOP");
    EXPECT_EQ(s.region_px, (std::array<int, 4>{16, 8, 512, 96}));
    EXPECT_EQ(s.exposure_s, 0.0005);
    EXPECT_EQ(s.frame_rate_hz, 200);
    EXPECT_EQ(s.pixel_format, "Mono12p");
    EXPECT_EQ(s.trigger, genicam::CameraTrigger::free);
    EXPECT_EQ(s.trigger_source, "Line2");
    EXPECT_EQ(s.packet_bytes, 9000);
    EXPECT_TRUE(s.ptp);
    EXPECT_TRUE(s.chunks);
    EXPECT_EQ(s.gain, 3.5);
    EXPECT_EQ(s.give_up_s, 5);
}

TEST(GenicamSettingsTest, OnlyTheIdIsRequired) {
    const genicam::GenicamSettings s = read("id = '127.0.0.1'\n");
    EXPECT_EQ(s.region_px[2], 0);
    EXPECT_EQ(s.trigger, genicam::CameraTrigger::dac);
    EXPECT_EQ(s.pixel_format, "Mono8");
    EXPECT_FALSE(s.gain.has_value());
    EXPECT_NE(refusal("exposure_s = 0.001\n").find("id: missing; expected"), std::string::npos);
}

TEST(GenicamSettingsTest, NamesErrorsWithLine) {
    const auto names = [](const std::string& text, const std::string& part) {
        const std::string words = refusal("id = 'x'\n" + text);
        EXPECT_NE(words.find(part), std::string::npos) << words;
        EXPECT_NE(words.find("bench.toml:2"), std::string::npos) << words;
    };
    names("pixel_format = 'RGB8'\n", "\"Mono12Packed\"");
    names("region_px = [0, 0, 0, 96]\n", "width and height at least 1");
    names("region_px = [0, 0.5, 8, 96]\n", "whole numbers");
    names("region_px = [0, 0, 8]\n", "4 numbers");
    names("trigger = 'sometimes'\n", "\"software\"");
    names("exposure_s = 0.02\nframe_rate_hz = 200\n", "0.005 s");
    names("packet_bytes = -1\n", "0 to 65000");
}

TEST(GenicamSettingsTest, LinesOfAravisDoNotReachTheTerminal) {
    genicam::log_lines_of_glib();
    testing::internal::CaptureStderr();
    arv_enable_interface("Carrier pigeon");
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

}  // namespace
}  // namespace shaker::hardware
