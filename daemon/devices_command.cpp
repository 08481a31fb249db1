#include <spdlog/fmt/fmt.h>
#include <spdlog/fmt/ranges.h>

#include <cstdio>
#include <nlohmann/json.hpp>

#include "daemon/commands.hpp"
#include "drivers/hardware/alsa_devices.hpp"
#include "drivers/hardware/genicam_devices.hpp"
#include "drivers/hardware/iio_devices.hpp"
#include "drivers/hardware/video_devices.hpp"

namespace shaker {

namespace {

using Json = nlohmann::ordered_json;

struct Found {
    std::vector<AlsaDevice> dacs;
    std::vector<IioContextSeen> accelerometers;
    std::vector<GenicamDevice> genicam;
    std::vector<VideoDevice> video;
};

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

Json json_of(const GenicamDevice& d) {
    Json j{{"id", d.id},       {"address", d.address}, {"vendor", d.vendor},
           {"model", d.model}, {"serial", d.serial},   {"protocol", d.protocol}};
    if (!d.trouble.empty()) {
        j["error"] = d.trouble;
        return j;
    }
    j["sensor_px"] = {d.sensor_width, d.sensor_height};
    j["pixel_formats"] = d.pixel_formats;
    j["rate_hz"] = {d.rate_hz.min, d.rate_hz.max};
    j["trigger_sources"] = d.trigger_sources;
    return j;
}

Json json_of(const VideoDevice& d) {
    Json j{{"path", d.path.string()},
           {"stable_id", d.stable_id.string()},
           {"name", d.name},
           {"driver", d.driver},
           {"pictures", d.pictures}};
    if (!d.trouble.empty()) j["error"] = d.trouble;
    return j;
}

template <class T>
Json json_of(const std::vector<T>& all) {
    Json j = Json::array();
    for (const T& one : all) j.push_back(json_of(one));
    return j;
}

std::string text_of(const IioContextSeen& c) {
    std::string s;
    if (!c.trouble.empty()) s += fmt::format("  {}: {}\n", c.uri, c.trouble);
    for (const IioDeviceSeen& d : c.devices) {
        s += fmt::format("  uri = \"{}\"  device = \"{}\"\n", c.uri, d.serial.empty() ? d.name : d.serial);
        s += fmt::format("      {} ({}), channels {}, {} stamps\n", d.name, d.id, fmt::join(d.channels, ", "),
                         d.has_stamps ? "with" : "no");
        s += fmt::format(
            "      rate {} Hz of {}; trigger {} of {}\n", d.rate_hz.empty() ? "not told" : d.rate_hz,
            d.rates_hz.empty() ? "not told" : d.rates_hz, d.trigger.empty() ? "none" : d.trigger,
            c.triggers.empty() ? std::string{"none"} : fmt::format("{}", fmt::join(c.triggers, ", ")));
    }
    return s;
}

std::string text_of(const GenicamDevice& d) {
    std::string s = fmt::format("  driver = \"genicam\"  id = \"{}\"\n      {} {} at {}, {}\n", d.id,
                                d.vendor, d.model, d.address, d.protocol);
    if (!d.trouble.empty()) return s + "      " + d.trouble + "\n";
    return s + fmt::format("      {} x {} px, {}; {} Hz; trigger {}\n", d.sensor_width, d.sensor_height,
                           fmt::join(d.pixel_formats, ", "), to_text(d.rate_hz),
                           fmt::join(d.trigger_sources, ", "));
}

std::string text_of(const VideoDevice& d) {
    const std::string id = (d.stable_id.empty() ? d.path : d.stable_id).string();
    std::string s =
        fmt::format("  driver = \"video\"  device = \"{}\"\n      {} ({})\n", id, d.name, d.driver);
    for (const std::string& picture : d.pictures) s += "      " + picture + "\n";
    return d.trouble.empty() ? s : s + "      " + d.trouble + "\n";
}

std::string text_of(const AlsaDevice& d) { return "  " + d.text() + "\n"; }

template <class T>
void print(const char* heading, const std::vector<T>& all) {
    std::string s;
    for (const T& one : all) s += text_of(one);
    fmt::print("{}\n{}", heading, s.empty() ? "  none\n" : s);
}

}  // namespace

void list_devices(const DevicesOptions& options) {
    Found found;
    found.dacs = options.pcm.empty() ? list_alsa_devices()
                                     : std::vector{describe_alsa_device(options.pcm, options.alsa_config)};
    found.accelerometers = list_iio_devices(options.iio);
    found.genicam = list_genicam_devices();
    found.video = list_video_devices();
    if (options.json) {
        const Json j{{"dacs", json_of(found.dacs)},
                     {"accelerometers", json_of(found.accelerometers)},
                     {"genicam_cameras", json_of(found.genicam)},
                     {"video_cameras", json_of(found.video)}};
        fmt::print("{}\n", j.dump(2));
        return;
    }
    print("[dac]", found.dacs);
    print("[accelerometer]", found.accelerometers);
    print("[[camera]] GenICam", found.genicam);
    print("[[camera]] video", found.video);
}

}  // namespace shaker
