#include "drivers/hardware/alsa/kind.hpp"

#include <spdlog/fmt/fmt.h>
#include <spdlog/fmt/ranges.h>

#include <nlohmann/json.hpp>

#include "drivers/hardware/alsa/alsa_dac.hpp"
#include "drivers/hardware/alsa/devices.hpp"

namespace shaker::alsa {

namespace {

using Json = nlohmann::ordered_json;

Json range(const AlsaDevice::Between& b) { return {b.least, b.most}; }

Json json_of(const AlsaDevice& d) {
    Json j{{"pcm", d.pcm}, {"name", d.name}};
    if (!d.error.empty()) {
        j["error"] = d.error;
        return j;
    }
    j["formats"] = Json::array();
    for (const SampleFormat f : d.formats) j["formats"].push_back(to_text(f));
    j["rates_hz"] = d.rates_hz;
    j["channels"] = range(d.channels);
    j["period_frames"] = range(d.period_frames);
    j["buffer_frames"] = range(d.buffer_frames);
    return j;
}

std::string text_of(const AlsaDevice& d) { return "  " + d.text() + "\n"; }

// Empty when it was not given.
std::string first(const hardware::Search& search, std::string_view name) {
    const auto found = search.find(name);
    return found == search.end() || found->second.empty() ? std::string{} : found->second.front();
}

}  // namespace

hardware::OpenDac read_kind(SettingsTable& table) {
    return [settings = read_alsa_settings(table)](hardware::Notes& notes) {
        auto dac = std::make_unique<AlsaDac>(settings);
        notes.push_back(dac->granted().text());
        return dac;
    };
}

std::vector<hardware::ListedDevice> list_kind(const hardware::Search& search) {
    std::vector<hardware::ListedDevice> all;
    const std::string pcm = first(search, "--pcm");
    const std::vector<AlsaDevice> found =
        pcm.empty() ? list_alsa_devices()
                    : std::vector{describe_alsa_device(pcm, first(search, "--alsa-config"))};
    for (const AlsaDevice& device : found) all.push_back({text_of(device), json_of(device).dump()});
    return all;
}

}  // namespace shaker::alsa
