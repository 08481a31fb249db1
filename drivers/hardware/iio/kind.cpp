#include "drivers/hardware/iio/kind.hpp"

#include <iio.h>
#include <spdlog/fmt/fmt.h>
#include <spdlog/fmt/ranges.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "drivers/errors.hpp"
#include "drivers/hardware/iio/context.hpp"
#include "drivers/hardware/iio/iio_accelerometer.hpp"

namespace shaker::iio {

namespace {

using Json = nlohmann::ordered_json;

struct ScanEnd {
    void operator()(iio_scan_context* scan) const noexcept { iio_scan_context_destroy(scan); }
};

constexpr const char* this_computer = "local:";

std::vector<std::string> scanned(const char* backend) {
    std::vector<std::string> uris;
    const std::unique_ptr<iio_scan_context, ScanEnd> scan{iio_create_scan_context(backend, 0)};
    if (!scan) return uris;
    iio_context_info** list = nullptr;
    const ssize_t count = iio_scan_context_get_info_list(scan.get(), &list);
    for (ssize_t i = 0; i < count; ++i) uris.push_back(iio_string(iio_context_info_get_uri(list[i])));
    if (count >= 0) iio_context_info_list_free(list);
    return uris;
}

std::string format_of(const iio_channel* channel) {
    const iio_data_format* f = iio_channel_get_data_format(channel);
    return (f->is_be ? "be:" : "le:") + std::string{f->is_signed ? "s" : "u"} + std::to_string(f->bits) +
           "/" + std::to_string(f->length) + ">>" + std::to_string(f->shift);
}

/// A device with its own description; its channels are scan elements with their format.
Json seen(const iio_device* device) {
    Json d{{"id", iio_string(iio_device_get_id(device))},
           {"name", iio_string(iio_device_get_name(device))},
           {"label", iio_string(iio_device_get_label(device))},
           {"serial", iio_serial(device).value_or("")},
           {"channels", Json::array()},
           {"rate_hz", ""},
           {"rates_hz", ""},
           {"trigger", ""},
           {"has_stamps", false}};
    const iio_channel* first = nullptr;
    for (unsigned i = 0; i < iio_device_get_channels_count(device); ++i) {
        const iio_channel* channel = iio_device_get_channel(device, i);
        if (!iio_channel_is_scan_element(channel) || iio_channel_is_output(channel)) continue;
        const std::string id = iio_string(iio_channel_get_id(channel));
        d["channels"].push_back(id + " " + format_of(channel));
        if (first == nullptr) first = channel;
        if (id == "timestamp") d["has_stamps"] = true;
    }
    if (first == nullptr) return d;
    const IioRate rate = iio_rate(device, first);
    d["rate_hz"] = rate.text().value_or("");
    d["rates_hz"] = rate.choice().value_or("");
    if (const iio_device* trigger = iio_trigger(device))
        d["trigger"] = iio_string(iio_device_get_name(trigger));
    return d;
}

/// A context: this computer, a USB device or a network address.
Json context_at(const std::string& uri) {
    const Json none{
        {"uri", uri}, {"description", ""}, {"triggers", Json::array()}, {"devices", Json::array()}};
    Json place = none;
    try {
        const IioContextHandle context = open_iio_context(uri);
        place["description"] = iio_string(iio_context_get_description(context.get()));
        for (unsigned i = 0; i < iio_context_get_devices_count(context.get()); ++i) {
            const iio_device* device = iio_context_get_device(context.get(), i);
            if (iio_device_is_trigger(device))
                place["triggers"].push_back(iio_string(iio_device_get_name(device)));
            else if (Json found = seen(device); !found["channels"].empty())
                place["devices"].push_back(std::move(found));
        }
    } catch (const DeviceError& e) {
        place = none;
        place["error"] = e.what();
        if (uri == this_computer && !std::filesystem::exists("/sys/bus/iio"))
            place["error"] =
                "no IIO accelerometer on this computer; --iio URI looks at another one, for example "
                "ip:192.168.2.1";
    }
    return place;
}

/// A text, or texts joined by commas; `none` when empty.
std::string words(const Json& value, const char* none = "") {
    if (value == "" || value.empty()) return none;
    if (value.is_string()) return value;
    return fmt::format("{}", fmt::join(value.get<std::vector<std::string>>(), ", "));
}

std::string text_of(const Json& c) {
    std::string s;
    if (c.contains("error")) s += fmt::format("  {}\n", words(c["error"]));
    for (const Json& d : c["devices"]) {
        s += fmt::format("  uri = \"{}\"  device = \"{}\"\n", words(c["uri"]),
                         words(d[d["serial"] == "" ? "name" : "serial"]));
        s += fmt::format("      {} ({}), channels {}, {} stamps\n", words(d["name"]), words(d["id"]),
                         words(d["channels"]), d["has_stamps"] ? "with" : "no");
        s += fmt::format("      rate {} Hz of {}; trigger {} of {}\n", words(d["rate_hz"], "unknown"),
                         words(d["rates_hz"], "unknown"), words(d["trigger"], "none"),
                         words(c["triggers"], "none"));
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
    std::vector<std::string> uris{this_computer};
    for (std::string& uri : scanned("usb")) uris.push_back(std::move(uri));
    if (const auto given = search.find("--iio"); given != search.end())
        uris.insert(uris.end(), given->second.begin(), given->second.end());
    std::vector<hardware::ListedDevice> all;
    for (const std::string& uri : uris) {
        const Json place = context_at(uri);
        all.push_back({text_of(place), place.dump()});
    }
    return all;
}

}  // namespace shaker::iio
