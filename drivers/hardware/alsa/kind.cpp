#include "drivers/hardware/alsa/kind.hpp"

#include <alsa/asoundlib.h>
#include <spdlog/fmt/fmt.h>
#include <spdlog/fmt/ranges.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "drivers/errors.hpp"
#include "drivers/hardware/alsa/alsa_dac.hpp"

namespace shaker::alsa {

namespace {

using Json = nlohmann::ordered_json;

void ask(snd_pcm_t* pcm, Json& device) {
    const auto owned = made(snd_pcm_hw_params_malloc, snd_pcm_hw_params_free);
    snd_pcm_hw_params_t* raw = owned.get();
    if (const int error = snd_pcm_hw_params_any(pcm, raw); error < 0)
        throw DeviceError{fmt::format("ALSA device {}: has no configuration: {}",
                                      device["pcm"].get<std::string>(), snd_strerror(error))};
    device["formats"] = Json::array();
    for (const auto format : {SampleFormat::s32, SampleFormat::s24, SampleFormat::s24_3, SampleFormat::s16})
        if (snd_pcm_hw_params_test_format(pcm, raw, static_cast<snd_pcm_format_t>(format_number(format))) ==
            0)
            device["formats"].push_back(to_text(format));
    device["rates_hz"] = possible_rates_hz(pcm, raw);
    device["channels"] = possible_channels(pcm, raw);
    const auto frames = [raw](auto get_least, auto get_most, auto... direction) {
        snd_pcm_uframes_t least = 0, most = 0;
        get_least(raw, &least, direction...);
        get_most(raw, &most, direction...);
        return Json{static_cast<unsigned>(least), static_cast<unsigned>(most)};
    };
    int* no_direction = nullptr;
    device["period_frames"] =
        frames(snd_pcm_hw_params_get_period_size_min, snd_pcm_hw_params_get_period_size_max, no_direction);
    device["buffer_frames"] =
        frames(snd_pcm_hw_params_get_buffer_size_min, snd_pcm_hw_params_get_buffer_size_max);
}

/// `pcm` is for a rig file, `name` for people; `config` (may be empty) may define the PCM.
Json described(Direction direction, const std::string& pcm, const std::string& name,
               const std::filesystem::path& config) {
    Json device{{"pcm", pcm}, {"name", name}};
    try {
        const AlsaHandle handle = open_alsa(direction, pcm, config);
        ask(static_cast<snd_pcm_t*>(handle.get()), device);
    } catch (const DeviceError& e) {
        device["error"] = e.what();
    }
    return device;
}

/// Adds the card's devices of one direction with their stable names.
void add_devices_of(int card, Direction direction, std::vector<Json>& devices) {
    snd_ctl_t* raw = nullptr;
    if (snd_ctl_open(&raw, fmt::format("hw:{}", card).c_str(), 0) < 0) return;  // removed since it was listed
    const std::unique_ptr<snd_ctl_t, int (*)(snd_ctl_t*)> control{raw, snd_ctl_close};
    const auto card_info = made(snd_ctl_card_info_malloc, snd_ctl_card_info_free);
    const auto info = made(snd_pcm_info_malloc, snd_pcm_info_free);
    snd_ctl_card_info_t* card_raw = card_info.get();
    snd_pcm_info_t* pcm_raw = info.get();
    if (snd_ctl_card_info(raw, card_raw) < 0) return;
    for (int number = -1; snd_ctl_pcm_next_device(raw, &number) == 0 && number >= 0;) {
        snd_pcm_info_set_device(pcm_raw, static_cast<unsigned>(number));
        snd_pcm_info_set_subdevice(pcm_raw, 0);
        snd_pcm_info_set_stream(
            pcm_raw, direction == Direction::playback ? SND_PCM_STREAM_PLAYBACK : SND_PCM_STREAM_CAPTURE);
        if (snd_ctl_pcm_info(raw, pcm_raw) < 0) continue;  // the other direction only
        devices.push_back(described(
            direction, fmt::format("hw:CARD={},DEV={}", snd_ctl_card_info_get_id(card_raw), number),
            fmt::format("{}, {}", snd_ctl_card_info_get_name(card_raw), snd_pcm_info_get_name(pcm_raw)), {}));
    }
}

std::string text_of(const Json& d) {
    const std::string pcm = d["pcm"], name = d["name"];
    const std::string head = name.empty() ? pcm : fmt::format("{} ({})", pcm, name);
    if (d.contains("error")) return fmt::format("  {}: {}\n", head, d["error"].get<std::string>());
    const auto formats = d["formats"].get<std::vector<std::string>>();
    const auto numbers = [&d](const char* key) { return d[key].get<std::vector<unsigned>>(); };
    return fmt::format(
        "  {}: formats {}; {} Hz; {} channels; periods {}, buffer {} samples\n", head,
        formats.empty() ? "none supported by shakerd" : fmt::format("{}", fmt::join(formats, ", ")),
        fmt::join(numbers("rates_hz"), ", "), fmt::join(numbers("channels"), ", "),
        fmt::join(numbers("period_frames"), " to "), fmt::join(numbers("buffer_frames"), " to "));
}

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

std::vector<hardware::ListedDevice> listed(Direction direction, const hardware::Search& search) {
    std::vector<Json> devices;
    if (const std::string pcm = first(search, "--pcm"); !pcm.empty())
        devices.push_back(described(direction, pcm, {}, first(search, "--alsa-config")));
    else
        for (int card = -1; snd_card_next(&card) == 0 && card >= 0;) add_devices_of(card, direction, devices);
    std::vector<hardware::ListedDevice> all;
    for (const Json& device : devices) all.push_back({text_of(device), device.dump()});
    return all;
}

std::vector<hardware::ListedDevice> list_kind(const hardware::Search& search) {
    return listed(Direction::playback, search);
}

}  // namespace shaker::alsa
