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

IioDeviceSeen seen(const std::string& uri, const iio_device* device) {
    IioDeviceSeen d{.uri = uri,
                    .id = iio_string(iio_device_get_id(device)),
                    .name = iio_string(iio_device_get_name(device)),
                    .label = iio_string(iio_device_get_label(device)),
                    .serial = iio_serial(device).value_or("")};
    const iio_channel* first = nullptr;
    for (unsigned i = 0; i < iio_device_get_channels_count(device); ++i) {
        const iio_channel* channel = iio_device_get_channel(device, i);
        if (!iio_channel_is_scan_element(channel) || iio_channel_is_output(channel)) continue;
        const std::string id = iio_string(iio_channel_get_id(channel));
        d.channels.push_back(id + " " + format_of(channel));
        if (first == nullptr) first = channel;
        d.has_stamps = d.has_stamps || id == "timestamp";
    }
    if (first == nullptr) return d;
    const IioRate rate = iio_rate(device, first);
    d.rate_hz = rate.text().value_or("");
    d.rates_hz = rate.choice().value_or("");
    if (const iio_device* trigger = iio_trigger(device)) d.trigger = iio_string(iio_device_get_name(trigger));
    return d;
}

IioContextSeen context_at(const std::string& uri) try {
    IioContextSeen place{.uri = uri};
    const IioContextHandle context = open_iio_context(uri);
    place.description = iio_string(iio_context_get_description(context.get()));
    for (unsigned i = 0; i < iio_context_get_devices_count(context.get()); ++i) {
        const iio_device* device = iio_context_get_device(context.get(), i);
        if (iio_device_is_trigger(device)) {
            place.triggers.push_back(iio_string(iio_device_get_name(device)));
            continue;
        }
        IioDeviceSeen found = seen(uri, device);
        if (!found.channels.empty()) place.devices.push_back(std::move(found));
    }
    return place;
} catch (const DeviceError& e) {
    if (uri == this_computer && !std::filesystem::exists("/sys/bus/iio"))
        return {.uri = uri,
                .trouble =
                    "no IIO accelerometer on this computer; --iio URI looks at another one, for example "
                    "ip:192.168.2.1"};
    return {.uri = uri, .trouble = e.what()};
}

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

std::vector<IioContextSeen> list_iio_devices(const std::vector<std::string>& uris) {
    std::vector<IioContextSeen> places{context_at(this_computer)};
    for (const std::string& uri : scanned("usb")) places.push_back(context_at(uri));
    for (const std::string& uri : uris) places.push_back(context_at(uri));
    return places;
}

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
