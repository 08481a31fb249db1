#include "drivers/hardware/alsa/mixer.hpp"

#include <alsa/asoundlib.h>
#include <spdlog/fmt/fmt.h>
#include <spdlog/fmt/ranges.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <sstream>

#include "drivers/errors.hpp"
#include "drivers/hardware/alsa/config.hpp"

namespace shaker::alsa {

namespace {

class Controls {
public:
    Controls(const std::string& name, const std::filesystem::path& config)
        : name_{name}, handle_{open_control(name, config)} {}

    /// Calls visit(id, info) for each control, in the card's order.
    template <class Visit>
    void each(const Visit& visit) {
        const auto list = made(snd_ctl_elem_list_malloc, snd_ctl_elem_list_free);
        check(snd_ctl_elem_list(ctl(), list.get()), "its controls cannot be listed");
        const unsigned count = snd_ctl_elem_list_get_count(list.get());
        check(snd_ctl_elem_list_alloc_space(list.get(), count), "its controls cannot be listed");
        check(snd_ctl_elem_list(ctl(), list.get()), "its controls cannot be listed");
        for (unsigned i = 0; i < snd_ctl_elem_list_get_used(list.get()); ++i) {
            const auto id = made(snd_ctl_elem_id_malloc, snd_ctl_elem_id_free);
            const auto info = made(snd_ctl_elem_info_malloc, snd_ctl_elem_info_free);
            snd_ctl_elem_list_get_id(list.get(), i, id.get());
            snd_ctl_elem_info_set_id(info.get(), id.get());
            if (snd_ctl_elem_info(ctl(), info.get()) >= 0) visit(id.get(), info.get());
        }
        snd_ctl_elem_list_free_space(list.get());
    }
    [[nodiscard]] snd_ctl_t* ctl() const noexcept { return static_cast<snd_ctl_t*>(handle_.get()); }
    void check(int error, const std::string& what) const {
        if (error < 0) fail(what + ": " + snd_strerror(error));
    }
    [[noreturn]] void fail(const std::string& what) const {
        throw DeviceError{"mixer " + name_ + ": " + what};
    }

private:
    std::string name_;
    AlsaHandle handle_;
};

using Id = snd_ctl_elem_id_t;
using Info = snd_ctl_elem_info_t;

std::string name_of(Id* id) {
    char* text = snd_ctl_ascii_elem_id_get(id);
    const std::unique_ptr<char, void (*)(void*)> owned{text, std::free};
    std::string name = text == nullptr ? "" : text;
    // Without the number, which depends on the order in which a driver makes its controls.
    if (name.starts_with("numid=")) name.erase(0, std::min(name.find(',') + 1, name.size()));
    return name;
}

bool compared(Info* info) {
    return snd_ctl_elem_info_is_readable(info) == 1 && snd_ctl_elem_info_is_writable(info) == 1 &&
           snd_ctl_elem_info_is_volatile(info) == 0 && snd_ctl_elem_info_is_inactive(info) == 0;
}

// Of types that are numbers; empty for others, and where the control cannot be read.
std::string values_of(const Controls& card, Id* id, Info* info) {
    if (snd_ctl_elem_info_is_readable(info) == 0) return {};
    const auto value = made(snd_ctl_elem_value_malloc, snd_ctl_elem_value_free);
    snd_ctl_elem_value_set_id(value.get(), id);
    if (snd_ctl_elem_read(card.ctl(), value.get()) < 0) return {};
    std::vector<long long> values;
    for (unsigned i = 0; i < snd_ctl_elem_info_get_count(info); ++i)
        switch (snd_ctl_elem_info_get_type(info)) {
            case SND_CTL_ELEM_TYPE_BOOLEAN:
                values.push_back(snd_ctl_elem_value_get_boolean(value.get(), i));
                break;
            case SND_CTL_ELEM_TYPE_INTEGER:
                values.push_back(snd_ctl_elem_value_get_integer(value.get(), i));
                break;
            case SND_CTL_ELEM_TYPE_ENUMERATED:
                values.push_back(snd_ctl_elem_value_get_enumerated(value.get(), i));
                break;
            case SND_CTL_ELEM_TYPE_INTEGER64:
                values.push_back(snd_ctl_elem_value_get_integer64(value.get(), i));
                break;
            default:
                return {};
        }
    return fmt::format("{}", fmt::join(values, ","));
}

std::string listed(Controls& card) {
    std::string lines;
    card.each([&](Id* id, Info* info) {
        const std::string values = values_of(card, id, info);
        const bool counts = compared(info) && !values.empty();
        lines += fmt::format("{}{} = {}\n", counts ? "" : "- ", name_of(id), values);
    });
    return lines;
}

void set(const Controls& card, Id* id, Info* info, const std::string& values) {
    const auto value = made(snd_ctl_elem_value_malloc, snd_ctl_elem_value_free);
    snd_ctl_elem_value_set_id(value.get(), id);
    std::istringstream in{values};
    std::string word;
    for (unsigned i = 0; std::getline(in, word, ','); ++i) {
        const long long number = std::strtoll(word.c_str(), nullptr, 10);
        switch (snd_ctl_elem_info_get_type(info)) {
            case SND_CTL_ELEM_TYPE_BOOLEAN:
                snd_ctl_elem_value_set_boolean(value.get(), i, number);
                break;
            case SND_CTL_ELEM_TYPE_ENUMERATED:
                snd_ctl_elem_value_set_enumerated(value.get(), i, static_cast<unsigned>(number));
                break;
            case SND_CTL_ELEM_TYPE_INTEGER64:
                snd_ctl_elem_value_set_integer64(value.get(), i, number);
                break;
            default:
                snd_ctl_elem_value_set_integer(value.get(), i, number);
        }
    }
    card.check(snd_ctl_elem_write(card.ctl(), value.get()), name_of(id) + " cannot be set to " + values);
}

// Sets what can be compared and has other values now. Returns the names.
std::vector<std::string> restore(Controls& card, const std::string& wanted) {
    std::vector<std::string> changed;
    for (int pass = 0; pass < 2; ++pass) {  // some controls change others
        std::map<std::string, std::string> left = settable_controls(wanted);
        card.each([&](Id* id, Info* info) {
            const auto found = left.find(name_of(id));
            if (found == left.end()) return;
            if (compared(info) && values_of(card, id, info) != found->second) {
                set(card, id, info, found->second);
                if (pass == 0) changed.push_back(found->first);
            }
            left.erase(found);
        });
        if (!left.empty()) card.fail("has no control " + left.begin()->first);
    }
    return changed;
}

}  // namespace

std::string control_of(const std::string& pcm) {
    if (!pcm.starts_with("hw:")) return {};
    const std::size_t named = pcm.find("CARD=");
    const std::size_t from = named == std::string::npos ? 3 : named;
    const std::string card = pcm.substr(from, pcm.find(',', from) - from);
    return card.find('=') == std::string::npos || named != std::string::npos ? "hw:" + card : "";
}

std::optional<MixerDevice> mixer_at(SettingsTable& table) {
    const std::string pcm = table.text("pcm"), file = table.text("alsa_config", "");
    const std::string control = table.text("mixer", control_of(pcm));
    if (control.empty()) return {};
    const std::filesystem::path config = file.empty() ? std::filesystem::path{} : table.folder() / file;
    // It stays open between two reads; after an error it is opened again.
    const auto card = std::make_shared<std::unique_ptr<Controls>>();
    return MixerDevice{.card = control,
                       .read =
                           [control, config, card] {
                               if (!*card) *card = std::make_unique<Controls>(control, config);
                               try {
                                   return listed(**card);
                               } catch (const DeviceError&) {
                                   card->reset();
                                   throw;
                               }
                           },
                       .restore =
                           [control, config](const std::string& wanted) {
                               Controls own{control, config};
                               return restore(own, wanted);
                           }};
}

}  // namespace shaker::alsa
