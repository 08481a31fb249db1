#include <gtest/gtest.h>

#include "drivers/errors.hpp"
#include "drivers/hardware/iio/settings.hpp"

namespace shaker::hardware {
namespace {

iio::IioSettings read(const std::string& text) {
    SettingsTable table = SettingsTable::from_text(text, "bench.toml");
    iio::IioSettings settings = iio::read_iio_settings(table);
    table.finish();
    return settings;
}

TEST(IioSettingsTest, AnEmptyTableMeansTheOnlyAccelerometerOfThisMachine) {
    const iio::IioSettings s = read("");
    EXPECT_EQ(s.uri, "local:");
    EXPECT_TRUE(s.device.empty());
    EXPECT_EQ(s.channels[2], "accel_z");
    EXPECT_FALSE(s.rate_hz.has_value());
    EXPECT_EQ(s.stamps, iio::IioStamps::host);
}

TEST(IioSettingsTest, StampsOfOtherMachineAreNotHostTime) {
    EXPECT_EQ(read("uri = 'ip:bench.local'").stamps, iio::IioStamps::device);
    EXPECT_EQ(read("uri = 'usb:1.2.3'").stamps, iio::IioStamps::device);
    EXPECT_EQ(read("uri = 'ip:127.0.0.1:30431'\nstamps = 'host'").stamps, iio::IioStamps::host);
    EXPECT_EQ(read("stamps = 'none'").stamps, iio::IioStamps::none);
}

TEST(IioSettingsTest, EveryKeyIsRead) {
    const iio::IioSettings s = read(
        "uri = 'ip:a'\ndevice = 'adxl355'\nchannels = ['x', 'y', 'z']\nrate_hz = 2000\ntrigger = 't'\n"
        "buffer_samples = 32\nkernel_buffers = 8\ntimeout_s = 0.5\ngive_up_s = 3\nshaker_axis = [0, 1, 0]\n"
        "clock_uncertainty_s = 0.001\nrange_mps2 = 19.6\n");
    EXPECT_EQ(s.device, "adxl355");
    EXPECT_EQ(s.channels[0], "x");
    EXPECT_EQ(s.rate_hz, 2000);
    EXPECT_EQ(s.trigger, "t");
    EXPECT_EQ(s.buffer_samples, 32);
    EXPECT_EQ(s.kernel_buffers, 8);
    EXPECT_EQ(s.timeout_s, 0.5);
    EXPECT_EQ(s.give_up_s, 3);
    EXPECT_EQ(s.shaker_axis[1], 1);
    EXPECT_EQ(s.clock_uncertainty_s, 0.001);
    EXPECT_EQ(s.range_mps2, 19.6);
}

TEST(IioSettingsTest, OneAxisWithoutGravityLiesAlongTheShaker) {
    const iio::IioSettings s = read("channels = ['voltage0']\ngravity = false\nhigh_pass_hz = 0.3\n");
    EXPECT_EQ(s.channels, std::vector<std::string>{"voltage0"});
    EXPECT_FALSE(s.gravity);
    EXPECT_EQ(s.shaker_axis, (std::array<double, 3>{1, 0, 0}));
}

TEST(IioSettingsTest, NamesRefusedValuesWithLine) {
    const auto words = [](const std::string& text) -> std::string {
        try {
            read(text);
        } catch (const InputError& e) {
            return e.what();
        }
        return "";
    };
    EXPECT_NE(words("\nuri = 'serial:/dev/x'").find("bench.toml:2"), std::string::npos);
    EXPECT_NE(words("timeout_s = 0").find("timeout_s"), std::string::npos);
    EXPECT_NE(words("shaker_axis = [1, 1, 0]").find("length"), std::string::npos);
    EXPECT_NE(words("channels = ['x', 'y', 'x']").find("\"x\" is given twice"), std::string::npos);
    EXPECT_NE(words("channels = []").find("channels"), std::string::npos);
    EXPECT_NE(words("channels = ['x']\nshaker_axis = [0, 1, 0]").find("which the sensor does not measure"),
              std::string::npos);
    EXPECT_NE(words("high_pass_hz = 0.3").find("gravity"), std::string::npos);
    EXPECT_NE(words("stamps = 'maybe'").find("stamps"), std::string::npos);
    EXPECT_NE(words("adress = 'x'").find("adress"), std::string::npos);
}

}  // namespace
}  // namespace shaker::hardware
