#include "drivers/mock/mock_files.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <fstream>

#include "drivers/errors.hpp"
#include "drivers/view_settings.hpp"

namespace shaker::mock {

namespace {

constexpr double period_s = 0.01, buffer_s = 0.2;  // a buffer longer than the pauses of a busy computer
constexpr double missing_s = 0.25, camera_missing_s = 1, watchdog_s = 2;

void write(const std::filesystem::path& file, const std::string& text) {
    std::ofstream out{file};
    out << text;
    out.close();
    if (!out) throw DeviceError{file.string() + ": " + std::strerror(errno)};
}

}  // namespace

std::string bench_serial(const std::string& name) {
    std::string serial;
    for (const char c : name) serial += static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    return serial;
}

std::filesystem::path write_bench_files(const MockBenchSettings& s, std::uint16_t iiod_port) {
    const std::filesystem::path config = s.folder / "asound.conf";
    std::filesystem::path rig = std::filesystem::absolute(s.folder / "rig.toml");
    write(config, fmt::format("pcm_type.shaker_mock {{ lib \"{}\" }}\n"
                              "pcm.shaker_mock {{ type shaker_mock converter \"{}\" }}\n",
                              std::filesystem::absolute(s.plugin).string(),
                              std::filesystem::absolute(s.folder / "converter").string()));
    std::string text = fmt::format(
        "# The mock bench: valid while the shaker-mock that wrote it runs.\n"
        "real_time = \"wanted\"\n"
        "[dac]\npcm = \"shaker_mock\"\nalsa_config = \"asound.conf\"\nrate_hz = {:.0f}\nformat = \"S32\"\n"
        "period_frames = {:.0f}\nbuffer_frames = {:.0f}\nfull_scale_V = {}\nsecond_channel = \"trigger\"\n\n"
        "[accelerometer]\nuri = \"ip:127.0.0.1:{}\"\ndevice = \"{}\"\nrate_hz = {}\nstamps = \"host\"\n"
        "range_mps2 = {}\n\n"
        "[limits]  # longer than on hardware, for busy computers\nmissing_s = {}\ncamera_missing_s = {}\n"
        "watchdog_s = {}\n\n{}",
        s.scene.dac_rate_hz, period_s * s.scene.dac_rate_hz, buffer_s * s.scene.dac_rate_hz,
        s.scene.dac_full_scale_v, iiod_port, IiodDescription{}.name, s.scene.accelerometer.rate_hz,
        s.scene.accelerometer.range_mps2, missing_s, camera_missing_s, watchdog_s,
        shaker_text(s.scene.shaker));
    for (const simulated::CameraTruth& c : s.scene.cameras)
        text += fmt::format(
            "\n[[camera]]\ndriver = \"genicam\"\nid = \"Shaker-Mock-{}\"\ntrigger = \"dac\"\n"
            "arrival_delay_s = {}\n{}",
            bench_serial(c.view.camera), c.view.exposure_s + c.latency_s, view_text(c.view));
    write(rig, text);
    return rig;
}

}  // namespace shaker::mock
