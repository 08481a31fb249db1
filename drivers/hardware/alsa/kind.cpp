#include "drivers/hardware/alsa/kind.hpp"

#include <alsa/asoundlib.h>
#include <spdlog/fmt/fmt.h>
#include <spdlog/fmt/ranges.h>

#include <array>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "drivers/errors.hpp"
#include "drivers/hardware/alsa/alsa_dac.hpp"
#include "drivers/hardware/alsa/config.hpp"

namespace shaker::alsa {

namespace {

void ask(snd_pcm_t* pcm, AlsaDevice& device) {
    const auto owned = made(snd_pcm_hw_params_malloc, snd_pcm_hw_params_free);
    snd_pcm_hw_params_t* raw = owned.get();
    if (const int error = snd_pcm_hw_params_any(pcm, raw); error < 0)
        throw DeviceError{
            fmt::format("ALSA device {}: has no configuration: {}", device.pcm, snd_strerror(error))};
    for (const auto format : {SampleFormat::s32, SampleFormat::s24, SampleFormat::s24_3, SampleFormat::s16})
        if (snd_pcm_hw_params_test_format(pcm, raw, static_cast<snd_pcm_format_t>(format_number(format))) ==
            0)
            device.formats.push_back(format);
    device.rates_hz = possible_rates_hz(pcm, raw);
    device.channels = possible_channels(pcm, raw);
    const auto frames = [raw](auto get_least, auto get_most, auto... direction) {
        snd_pcm_uframes_t least = 0, most = 0;
        get_least(raw, &least, direction...);
        get_most(raw, &most, direction...);
        return AlsaDevice::Between{static_cast<unsigned>(least), static_cast<unsigned>(most)};
    };
    int* no_direction = nullptr;
    device.period_frames =
        frames(snd_pcm_hw_params_get_period_size_min, snd_pcm_hw_params_get_period_size_max, no_direction);
    device.buffer_frames =
        frames(snd_pcm_hw_params_get_buffer_size_min, snd_pcm_hw_params_get_buffer_size_max);
}

/// Adds the card's devices of one direction with their stable names.
void add_devices_of(int card, Direction direction, std::vector<AlsaDevice>& devices) {
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
        AlsaDevice device = describe_alsa_device(
            direction, fmt::format("hw:CARD={},DEV={}", snd_ctl_card_info_get_id(card_raw), number), {});
        device.name =
            fmt::format("{}, {}", snd_ctl_card_info_get_name(card_raw), snd_pcm_info_get_name(pcm_raw));
        devices.push_back(std::move(device));
    }
}

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
    j["channels"] = d.channels;
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

std::string AlsaDevice::text() const {
    const std::string head = name.empty() ? pcm : fmt::format("{} ({})", pcm, name);
    if (!error.empty()) return fmt::format("{}: {}", head, error);
    std::vector<std::string_view> names;
    for (const SampleFormat format : formats) names.push_back(to_text(format));
    return fmt::format(
        "{}: formats {}; {} Hz; {} channels; periods {} to {}, buffer {} to {} samples", head,
        names.empty() ? "none supported by shakerd" : fmt::format("{}", fmt::join(names, ", ")),
        fmt::join(rates_hz, ", "), fmt::join(channels, ", "), period_frames.least, period_frames.most,
        buffer_frames.least, buffer_frames.most);
}

std::vector<AlsaDevice> list_alsa_devices(Direction direction) {
    std::vector<AlsaDevice> devices;
    for (int card = -1; snd_card_next(&card) == 0 && card >= 0;) add_devices_of(card, direction, devices);
    return devices;
}

AlsaDevice describe_alsa_device(Direction direction, const std::string& pcm,
                                const std::filesystem::path& config) {
    AlsaDevice device;
    device.pcm = pcm;
    try {
        const AlsaHandle handle = open_alsa(direction, pcm, config);
        ask(static_cast<snd_pcm_t*>(handle.get()), device);
    } catch (const DeviceError& e) {
        device.error = e.what();
    }
    return device;
}

hardware::OpenDac read_kind(SettingsTable& table) {
    return [settings = read_alsa_settings(table)](hardware::Notes& notes) {
        auto dac = std::make_unique<AlsaDac>(settings);
        notes.push_back(dac->granted().text());
        return dac;
    };
}

std::vector<hardware::ListedDevice> listed(Direction direction, const hardware::Search& search) {
    std::vector<hardware::ListedDevice> all;
    const std::string pcm = first(search, "--pcm");
    const std::vector<AlsaDevice> found =
        pcm.empty() ? list_alsa_devices(direction)
                    : std::vector{describe_alsa_device(direction, pcm, first(search, "--alsa-config"))};
    for (const AlsaDevice& device : found) all.push_back({text_of(device), json_of(device).dump()});
    return all;
}

std::vector<hardware::ListedDevice> list_kind(const hardware::Search& search) {
    return listed(Direction::playback, search);
}

}  // namespace shaker::alsa
