#pragma once
// A kind of device as one row of a table: its name, its settings, how to open it, how to list connected
// devices, and its words in the self-test.
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/devices.hpp"
#include "drivers/settings_table.hpp"

namespace shaker::hardware {

/// What a device granted, one line for each request.
using Notes = std::vector<std::string>;

/// One connected device, or one place that could not be searched.
struct ListedDevice {
    std::string text;  // lines in the words of a rig file
    std::string json;  // the same as one JSON object
};

/// An option of a search: "--iio ip:192.168.1.7".
struct SearchOption {
    std::string_view name;   // "--iio"
    std::string_view value;  // name of its value in help: "URI"
    std::string_view help;   // one line without its full stop
    bool many = false;       // takes several values
    bool file = false;       // the value is a file that exists
};
/// Values of search options, by name; options that were not given are missing.
using Search = std::map<std::string, std::vector<std::string>, std::less<>>;

/// `Open` opens a device whose settings have been read. Throws DeviceError.
/// `Read` reads the keys of the kind; it leaves other keys and finish() to the caller. Throws InputError.
template <class Read>
struct DeviceKind {
    std::string_view name;     // value of the key `driver` in a rig file
    std::string_view heading;  // of a list: "[[camera]] GenICam"
    std::string_view key;      // of a list in JSON: "genicam_cameras"
    Read read;
    std::vector<ListedDevice> (*list)(const Search&);  // does not throw for a device
    std::span<const SearchOption> search{};
    DeviceAdvice advice{};  // of the self-test
    /// The controls that belong to the device; null: the kind has none. Reads its keys.
    std::optional<MixerDevice> (*mixer)(SettingsTable&) = nullptr;
};

using OpenCamera = std::function<std::unique_ptr<Camera>(View, Notes&)>;
using OpenAccelerometer = std::function<std::unique_ptr<Accelerometer>(Notes&)>;
using OpenDac = std::function<std::unique_ptr<Dac>(Notes&)>;

/// May change the view: a camera that the DAC triggers.
using CameraKind = DeviceKind<OpenCamera (*)(SettingsTable&, View&)>;
using AccelerometerKind = DeviceKind<OpenAccelerometer (*)(SettingsTable&)>;
using DacKind = DeviceKind<OpenDac (*)(SettingsTable&)>;

/// The kind of this name; null for an unknown name.
template <class Kind>
const Kind* find_kind(std::span<const Kind> kinds, std::string_view name) {
    for (const Kind& kind : kinds)
        if (kind.name == name) return &kind;
    return nullptr;
}

/// The kind that the key `driver` names; without the key the first kind when `optional`. InputError names the
/// value and the allowed kinds.
template <class Kind>
const Kind& read_kind(SettingsTable& table, std::span<const Kind> kinds, bool optional) {
    std::string allowed;
    for (const Kind& kind : kinds)
        allowed += (allowed.empty() ? "\"" : ", \"") + std::string{kind.name} + "\"";
    if (!table.has("driver") && optional) return kinds.front();
    if (!table.has("driver")) table.fail("driver", "this key is missing: expected one of " + allowed);
    const std::string name = table.text("driver");
    const Kind* const found = find_kind(kinds, name);
    if (found == nullptr) table.fail("driver", "\"" + name + "\" is not allowed: expected one of " + allowed);
    return *found;
}

}  // namespace shaker::hardware
