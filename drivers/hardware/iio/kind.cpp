#include "drivers/hardware/iio/kind.hpp"

#include <spdlog/fmt/fmt.h>
#include <spdlog/fmt/ranges.h>

#include <nlohmann/json.hpp>

#include "drivers/hardware/iio/devices.hpp"
#include "drivers/hardware/iio/iio_accelerometer.hpp"

namespace shaker::iio {

namespace {

using Json = nlohmann::ordered_json;

Json json_of(const IioContextSeen& c) {
    Json j{
        {"uri", c.uri}, {"description", c.description}, {"triggers", c.triggers}, {"devices", Json::array()}};
    if (!c.trouble.empty()) j["error"] = c.trouble;
    for (const IioDeviceSeen& d : c.devices)
        j["devices"].push_back({{"id", d.id},
                                {"name", d.name},
                                {"label", d.label},
                                {"serial", d.serial},
                                {"channels", d.channels},
                                {"rate_hz", d.rate_hz},
                                {"rates_hz", d.rates_hz},
                                {"trigger", d.trigger},
                                {"has_stamps", d.has_stamps}});
    return j;
}

std::string text_of(const IioContextSeen& c) {
    std::string s;
    if (!c.trouble.empty()) s += fmt::format("  {}\n", c.trouble);
    for (const IioDeviceSeen& d : c.devices) {
        s += fmt::format("  uri = \"{}\"  device = \"{}\"\n", c.uri, d.serial.empty() ? d.name : d.serial);
        s += fmt::format("      {} ({}), channels {}, {} stamps\n", d.name, d.id, fmt::join(d.channels, ", "),
                         d.has_stamps ? "with" : "no");
        s += fmt::format(
            "      rate {} Hz of {}; trigger {} of {}\n", d.rate_hz.empty() ? "unknown" : d.rate_hz,
            d.rates_hz.empty() ? "unknown" : d.rates_hz, d.trigger.empty() ? "none" : d.trigger,
            c.triggers.empty() ? std::string{"none"} : fmt::format("{}", fmt::join(c.triggers, ", ")));
    }
    return s;
}

}  // namespace

hardware::OpenAccelerometer read_kind(SettingsTable& table) {
    return [settings = read_iio_settings(table)](hardware::Notes& notes) {
        return open_iio_accelerometer(settings, &notes);
    };
}

std::vector<hardware::ListedDevice> list_kind(const hardware::Search& search) {
    std::vector<hardware::ListedDevice> all;
    const auto found = search.find("--iio");
    const auto uris = found == search.end() ? std::vector<std::string>{} : found->second;
    for (const IioContextSeen& device : list_iio_devices(uris))
        all.push_back({text_of(device), json_of(device).dump()});
    return all;
}

}  // namespace shaker::iio
