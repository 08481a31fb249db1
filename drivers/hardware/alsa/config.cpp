#include "drivers/hardware/alsa/config.hpp"

#include <alsa/asoundlib.h>
#include <spdlog/fmt/fmt.h>
#include <spdlog/fmt/ranges.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <fstream>
#include <set>
#include <thread>

#include "drivers/errors.hpp"

namespace shaker::alsa {

namespace {

using namespace std::chrono_literals;

constexpr int mode =
    SND_PCM_NONBLOCK | SND_PCM_NO_AUTO_RESAMPLE | SND_PCM_NO_AUTO_CHANNELS | SND_PCM_NO_AUTO_FORMAT;

// The device of a killed process is busy until its ramp has been played.
constexpr std::chrono::milliseconds patience = 2s, pause = 50ms;

void check(int error, const std::string& what) {
    if (error < 0) throw DeviceError{what + ": " + snd_strerror(error)};
}

struct ReleaseConfig {
    void operator()(snd_config_t* config) const noexcept { snd_config_delete(config); }
};
using Config = std::unique_ptr<snd_config_t, ReleaseConfig>;

/// The system's configuration with the file's definitions added.
Config merged(const std::filesystem::path& file) {
    snd_config_t* top = nullptr;
    check(snd_config_update_ref(&top), "ALSA's configuration");
    snd_config_t* copied = nullptr;
    const int error = snd_config_copy(&copied, top);
    snd_config_unref(top);
    check(error, "ALSA's configuration");
    Config config{copied};
    snd_input_t* input = nullptr;
    check(snd_input_stdio_open(&input, file.c_str(), "r"), file.string());
    const int parsed = snd_config_load(config.get(), input);
    snd_input_close(input);
    check(parsed, file.string());
    return config;
}

// Number of the card in "hw:CARD=M2,DEV=0" or "hw:1,0"; negative when the name has none.
int card_of(const std::string& name) {
    const std::size_t colon = name.find(':');
    if (colon == std::string::npos) return -1;
    constexpr std::string_view key = "CARD=";
    const std::size_t named = name.find(key, colon);
    std::string card = name.substr(named == std::string::npos ? colon + 1 : named + key.size());
    card = card.substr(0, card.find(','));
    return snd_card_get_index(card.c_str());
}

}  // namespace

std::string holders(Direction direction, int card, const std::filesystem::path& asound,
                    const std::filesystem::path& proc) {
    const std::string first = card < 0 ? "card" : fmt::format("card{}/", card);
    const char side = direction == Direction::playback ? 'p' : 'c';
    std::set<std::string> found;
    std::error_code none;
    const auto end = std::filesystem::recursive_directory_iterator{};
    for (auto at = std::filesystem::recursive_directory_iterator{asound, none}; at != end;
         at.increment(none)) {
        // card1/pcm0p/sub0/status
        const std::string place = at->path().lexically_relative(asound).string();
        const std::size_t pcm = place.find("/pcm");
        if (!place.starts_with(first) || !place.ends_with("/status") || pcm == std::string::npos ||
            place[place.find('/', pcm + 1) - 1] != side)
            continue;
        std::ifstream status{at->path()};
        for (std::string line; std::getline(status, line);) {
            if (!line.starts_with("owner_pid")) continue;
            const std::string process = line.substr(line.find_last_of(" :\t") + 1);
            std::string name;
            std::getline(std::ifstream{proc / process / "comm"}, name);
            found.insert(fmt::format("{} (process {})", name.empty() ? "a program" : name, process));
        }
    }
    return fmt::format("{}", fmt::join(found, ", "));
}

AlsaHandle open_alsa(Direction direction, const std::string& name, const std::filesystem::path& file) {
    const snd_pcm_stream_t stream =
        direction == Direction::playback ? SND_PCM_STREAM_PLAYBACK : SND_PCM_STREAM_CAPTURE;
    const Config config = file.empty() ? nullptr : merged(file);
    snd_pcm_t* pcm = nullptr;
    int error = -EBUSY;
    for (auto waited = 0ms; error == -EBUSY && waited < patience; waited += pause) {
        if (waited > 0ms) std::this_thread::sleep_for(pause);
        error = config ? snd_pcm_open_lconf(&pcm, name.c_str(), stream, mode, config.get())
                       : snd_pcm_open(&pcm, name.c_str(), stream, mode);
    }
    const std::string who = error == -EBUSY ? holders(direction, card_of(name)) : std::string{};
    const std::string remedy =
        error == -ENODEV || error == -ENOENT ? "; \"shakerd devices\" lists the sound cards"
        : who.empty()
            ? ""
            : fmt::format(
                  "; {} held by {}: end that program, or take the card out of its hands (WIRING.md, "
                  "\"A sound server\")",
                  card_of(name) < 0 ? "sound cards are" : "its card is", who);
    check(error, "ALSA device " + name + ": cannot be opened" + remedy);
    return {pcm, [](void* opened) { snd_pcm_close(static_cast<snd_pcm_t*>(opened)); }};
}

AlsaHandle open_control(const std::string& name, const std::filesystem::path& file) {
    const Config config = file.empty() ? nullptr : merged(file);
    snd_ctl_t* ctl = nullptr;
    check(config ? snd_ctl_open_lconf(&ctl, name.c_str(), SND_CTL_NONBLOCK, config.get())
                 : snd_ctl_open(&ctl, name.c_str(), SND_CTL_NONBLOCK),
          "mixer " + name + ": cannot be opened");
    return {ctl, [](void* opened) { snd_ctl_close(static_cast<snd_ctl_t*>(opened)); }};
}

std::string card_name(void* pcm) {
    const auto info = made(snd_pcm_info_malloc, snd_pcm_info_free);
    if (snd_pcm_info(static_cast<snd_pcm_t*>(pcm), info.get()) < 0) return {};
    char* name = nullptr;
    if (snd_card_get_longname(snd_pcm_info_get_card(info.get()), &name) < 0) return {};
    const std::unique_ptr<char, void (*)(void*)> owned{name, std::free};
    return name;
}

int format_number(SampleFormat format) noexcept {
    constexpr std::array numbers{SND_PCM_FORMAT_S32_LE, SND_PCM_FORMAT_S24_LE, SND_PCM_FORMAT_S24_3LE,
                                 SND_PCM_FORMAT_S16_LE};
    return numbers.at(static_cast<std::size_t>(format));
}

std::string allowed_formats(void* pcm, void* hw) {
    std::string list;
    for (const auto format : {SampleFormat::s32, SampleFormat::s24, SampleFormat::s24_3, SampleFormat::s16})
        if (snd_pcm_hw_params_test_format(static_cast<snd_pcm_t*>(pcm), static_cast<snd_pcm_hw_params_t*>(hw),
                                          static_cast<snd_pcm_format_t>(format_number(format))) == 0)
            list.append(list.empty() ? "" : ", ").append(to_text(format));
    return list.empty() ? "none supported by shakerd" : list;
}

// The usual rates that a card has, or its range when it has none of them.
std::string allowed_rates(void* pcm, void* hw) {
    const std::vector<int> has = possible_rates_hz(pcm, hw);
    if (!has.empty()) return fmt::format("it has {}", fmt::join(has, ", "));
    unsigned least = 0, most = 0;
    snd_pcm_hw_params_get_rate_min(static_cast<snd_pcm_hw_params_t*>(hw), &least, nullptr);
    snd_pcm_hw_params_get_rate_max(static_cast<snd_pcm_hw_params_t*>(hw), &most, nullptr);
    return fmt::format("must be {} to {}", least, most);
}

std::vector<int> possible_rates_hz(void* pcm, void* hw) {
    constexpr std::array usual{8000,  16000,  22050,  32000,  44100,  48000,  88200,
                               96000, 176400, 192000, 352800, 384000, 705600, 768000};
    std::vector<int> has;
    for (const int rate : usual)
        if (snd_pcm_hw_params_test_rate(static_cast<snd_pcm_t*>(pcm), static_cast<snd_pcm_hw_params_t*>(hw),
                                        static_cast<unsigned>(rate), 0) == 0)
            has.push_back(rate);
    return has;
}

std::vector<int> possible_channels(void* pcm, void* hw) {
    std::vector<int> has;
    for (unsigned n = 1; n <= 32; ++n)
        if (snd_pcm_hw_params_test_channels(static_cast<snd_pcm_t*>(pcm),
                                            static_cast<snd_pcm_hw_params_t*>(hw), n) == 0)
            has.push_back(static_cast<int>(n));
    return has;
}

}  // namespace shaker::alsa
