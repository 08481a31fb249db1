// Settings in a rig file, values granted by a device, and the list of devices.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "drivers/errors.hpp"
#include "drivers/hardware/alsa/alsa_dac.hpp"
#include "drivers/hardware/alsa/config.hpp"
#include "drivers/hardware/alsa/kind.hpp"
#include "drivers/hardware/alsa/settings.hpp"
#include "tests/support/devices/mock_dac.hpp"

namespace shaker::hardware {
namespace {

using test::MockDac;

alsa::AlsaSettings read(const std::string& text) {
    SettingsTable table = SettingsTable::from_text(text, "rigs/bench.toml");
    alsa::AlsaSettings settings = alsa::read_alsa_settings(table);
    table.finish();
    return settings;
}

template <class Error, class Action>
std::string refusal(Action action) {
    try {
        action();
    } catch (const Error& e) {
        return e.what();
    }
    return "nothing was thrown";
}
void expect_says(const std::string& text, const std::string& part) {
    EXPECT_NE(text.find(part), std::string::npos) << '"' << part << "\" was expected in: " << text;
}

TEST(AlsaSettingsTest, PcmAndFullScaleAreEnough) {
    const alsa::AlsaSettings s = read("pcm = 'hw:CARD=Device,DEV=0'\nfull_scale_V = 1.75");
    EXPECT_EQ(s.pcm, "hw:CARD=Device,DEV=0");
    EXPECT_TRUE(s.alsa_config.empty());
    EXPECT_EQ(s.format, alsa::SampleFormat::s32);
    EXPECT_EQ(s.second_channel, alsa::SecondChannel::trigger);
    EXPECT_EQ(s.ramp_frames(), 2400);
    EXPECT_TRUE(s.dither);
    const double queue_ms = 1e3 * (s.buffer_frames - s.ramp_frames()) / s.rate_hz;
    EXPECT_TRUE(queue_ms >= 10 && queue_ms <= 20) << "as WIRING.md advises";
    EXPECT_EQ(s.buffer_frames % s.period_frames, 0);
}

TEST(AlsaSettingsTest, EveryKeyIsRead) {
    const alsa::AlsaSettings s = read(
        "pcm = 'x'\nalsa_config = 'mock/asound.conf'\nrate_hz = 96000\nformat = 'S24_3'\n"
        "period_frames = 96\nbuffer_frames = 2048\nfull_scale_V = 2.8\nsecond_channel = 'tone'\n"
        "second_level = 0.25\npulse_s = 2e-4\ntone_hz = 440\nramp_s = 0.015\ndither = false");
    EXPECT_EQ(s.alsa_config, std::filesystem::path{"rigs/mock/asound.conf"});
    EXPECT_EQ(s.rate_hz, 96000);
    EXPECT_EQ(s.format, alsa::SampleFormat::s24_3);
    EXPECT_EQ(s.period_frames, 96);
    EXPECT_EQ(s.buffer_frames, 2048);
    EXPECT_EQ(s.full_scale_V, 2.8);
    EXPECT_EQ(s.second_channel, alsa::SecondChannel::tone);
    EXPECT_EQ(s.second_level, 0.25);
    EXPECT_EQ(s.pulse_s, 2e-4);
    EXPECT_EQ(s.tone_hz, 440);
    EXPECT_EQ(s.ramp_frames(), 1440);
    EXPECT_FALSE(s.dither);
}

TEST(AlsaSettingsTest, EnableToneIsOnASpareChannel) {
    const std::string head = "pcm = 'x'\nfull_scale_V = 1\n";
    EXPECT_EQ(read(head).enable_channel, 0);
    const alsa::AlsaSettings s = read(head +
                                      "enable_channel = 4\nenable_level = 0.5\nenable_hz = 2000\n"
                                      "enable_before_s = 0.5");
    EXPECT_EQ(s.enable_channel, 4);
    EXPECT_EQ(s.enable_level, 0.5);
    EXPECT_EQ(s.enable_hz, 2000);
    EXPECT_EQ(s.enable_before_s, 0.5);
    const auto said = [&](const std::string& keys) {
        return refusal<InputError>([&] { read(head + keys); });
    };
    expect_says(said("enable_channel = 2"), "enable_channel: 2 is not spare: channel 1 is the drive");
    expect_says(said("enable_channel = 2"), "must be another one, 1 to 64");
    EXPECT_EQ(read(head + "enable_channel = 2\nsecond_channel = 'off'").channels(), 2);
    EXPECT_EQ(read(head + "drive_channel = 3\nenable_channel = 1").channels(), 3);
    expect_says(said("enable_hz = 500"), "enable_hz: this key needs enable_channel");
    expect_says(said("enable_channel = 3\nenable_hz = 50"), "enable_hz");
    expect_says(said("enable_channel = 3\nenable_before_s = 0"), "enable_before_s");
}

TEST(AlsaSettingsTest, DriveAndTriggerAreOnTheirChannels) {
    const std::string head = "pcm = 'x'\nfull_scale_V = 1\n";
    const alsa::AlsaSettings s = read(head + "drive_channel = 3\ntrigger_channel = 4\npulse_hz = 1000");
    EXPECT_EQ(s.drive_channel, 3);
    EXPECT_EQ(s.trigger_channel, 4);
    EXPECT_EQ(s.pulse_hz, 1000);
    EXPECT_EQ(s.channels(), 4);
    EXPECT_EQ(read(head + "drive_channel = 2").trigger_channel, 1);
    const auto said = [&](const std::string& keys) {
        return refusal<InputError>([&] { read(head + keys); });
    };
    expect_says(said("drive_channel = 2\ntrigger_channel = 2"),
                "trigger_channel: 2 is the drive's channel, too");
    expect_says(said("drive_channel = 65"), "1 to 64");
    expect_says(said("second_channel = 'off'\ntrigger_channel = 2"), "this key needs second_channel");
    expect_says(said("second_channel = 'tone'\npulse_hz = 10"), "pulse_hz: this key needs second_channel");
    expect_says(said("pulse_hz = 5001"), "0.1 to 5000");
}

TEST(AlsaSettingsTest, RefusesBufferTooSmallForRamp) {
    const std::string said = refusal<InputError>(
        [] { read("pcm = 'x'\nfull_scale_V = 1\nperiod_frames = 256\nbuffer_frames = 2911"); });
    expect_says(said, "bench.toml:4");
    expect_says(said, "at least 2912");
    EXPECT_EQ(read("pcm = 'x'\nfull_scale_V = 1\nperiod_frames = 256\nbuffer_frames = 2912").buffer_frames,
              2912);
}

TEST(AlsaGrantedTest, ReportsGrantedSettingsInOneLine) {
    MockDac mock;
    const alsa::AlsaDac dac{mock.settings};
    EXPECT_TRUE(dac.granted().rewinds);
    EXPECT_TRUE(dac.granted().monotonic);
    const std::string line = dac.granted().text();
    expect_says(line, "shaker: S32 at 48000 Hz, 2 channels, period 480, buffer 9600 samples (200.0 ms)");
    expect_says(line, "a ramp to zero is queued behind the drive");
}

TEST(AlsaGrantedTest, TakesTheNextChannelCountThatTheCardHas) {
    MockDac mock;
    alsa::AlsaSettings s = mock.settings;
    s.enable_channel = 4;
    EXPECT_EQ(alsa::AlsaDac{s}.granted().channels, 8);
}

TEST(AlsaGrantedTest, RefusesUnsupportedSettingsWithRange) {
    MockDac mock;
    alsa::AlsaSettings s = mock.settings;
    s.rate_hz = 44100;
    expect_says(refusal<DeviceError>([&] { alsa::AlsaDac{s}; }),
                "ALSA device shaker: rate_hz 44100 is not possible: it has 48000");
    s = mock.settings;
    s.period_frames = 3;
    expect_says(refusal<DeviceError>([&] { alsa::AlsaDac{s}; }),
                "period_frames 3 is not possible: must be 8 to ");
    s = mock.settings;
    s.enable_channel = 9;
    expect_says(refusal<DeviceError>([&] { alsa::AlsaDac{s}; }),
                "enable_channel 9 is not possible; the channel counts it has are 2, 3, 8");
    s = mock.settings;
    s.drive_channel = 10;
    expect_says(refusal<DeviceError>([&] { alsa::AlsaDac{s}; }), "drive_channel 10 is not possible");
    s = mock.settings;
    s.pcm = "not_there";
    const std::string said = refusal<DeviceError>([&] { alsa::AlsaDac{s}; });
    expect_says(said, "not_there");
    expect_says(said, "No such file or directory");
}

TEST(AlsaDevicesTest, DeviceNamesAreStableAndOpen) {
    for (const ListedDevice& listed : alsa::list_kind({})) {  // none in most test machines
        const auto device = nlohmann::json::parse(listed.json);
        expect_says(device.at("pcm"), "hw:CARD=");
        EXPECT_NE(device.at("name"), "");
        EXPECT_TRUE(device.contains("error") || !device.at("channels").empty()) << listed.text;
    }
}

ListedDevice described(const std::string& pcm, const std::filesystem::path& config) {
    return alsa::list_kind({{"--pcm", {pcm}}, {"--alsa-config", {config.string()}}}).at(0);
}

TEST(AlsaDevicesTest, DescribesDeviceDefinedInFile) {
    const MockDac mock;
    const ListedDevice listed = described("shaker", mock.settings.alsa_config);
    const auto device = nlohmann::json::parse(listed.json);
    EXPECT_FALSE(device.contains("error")) << listed.text;
    EXPECT_EQ(device.at("formats"), nlohmann::json::array({"S32", "S24", "S24_3", "S16"}));
    EXPECT_EQ(device.at("rates_hz"), nlohmann::json::array({48000}));
    EXPECT_EQ(device.at("channels"), nlohmann::json::array({2, 3, 8}));
    expect_says(listed.text, "  shaker: formats S32, S24, S24_3, S16; 48000 Hz; 2, 3, 8 channels; periods ");
}

TEST(AlsaDevicesTest, DescribesBusyOrUnknownDeviceByError) {
    const MockDac mock;
    const alsa::AlsaDac dac{mock.settings};
    expect_says(described("shaker", mock.settings.alsa_config).text, "busy");
    expect_says(nlohmann::json::parse(described("not_there", {}).json).at("error"),
                "No such file or directory");
}

// As the kernel lists a card that PipeWire plays to and records from, and another one of somebody else.
TEST(AlsaDevicesTest, NamesTheProgramThatHoldsACard) {
    const std::filesystem::path folder = std::filesystem::path{testing::TempDir()} / "holders-of-cards";
    std::filesystem::remove_all(folder);
    const std::filesystem::path asound = folder / "asound", proc = folder / "proc";
    const auto write = [](const std::filesystem::path& file, const std::string& text) {
        std::filesystem::create_directories(file.parent_path());
        std::ofstream{file} << text;
    };
    write(asound / "card1/pcm0p/sub0/status", "state: RUNNING\nowner_pid   : 812\ntrigger_time: 1.5\n");
    write(asound / "card1/pcm0c/sub0/status", "closed\n");
    write(asound / "card1/pcm0c/sub1/status", "state: RUNNING\nowner_pid   : 812\n");
    write(asound / "card10/pcm0p/sub0/status", "state: SETUP\nowner_pid   : 77\n");
    write(asound / "card1/pcm0p/info", "owner_pid   : 5\n");
    write(proc / "812/comm", "pipewire\n");
    const auto of = [&](alsa::Direction direction, int card) {
        return alsa::holders(direction, card, asound, proc);
    };
    EXPECT_EQ(of(alsa::Direction::playback, 1), "pipewire (process 812)");
    EXPECT_EQ(of(alsa::Direction::capture, 1), "pipewire (process 812)");
    EXPECT_EQ(of(alsa::Direction::playback, 10), "a program (process 77)");
    EXPECT_EQ(of(alsa::Direction::capture, 10), "");
    EXPECT_EQ(of(alsa::Direction::playback, -1), "a program (process 77), pipewire (process 812)");
    EXPECT_EQ(alsa::holders(alsa::Direction::playback, 1, folder / "none", proc), "");
}

}  // namespace
}  // namespace shaker::hardware
