#include "drivers/hardware/iio/settings.hpp"

#include <algorithm>

#include "drivers/view_settings.hpp"

namespace shaker::iio {
namespace {

bool is_uri(const std::string& text) {
    constexpr std::array<std::string_view, 3> backends{"local:", "ip:", "usb:"};
    return std::ranges::any_of(backends, [&](std::string_view b) { return text.starts_with(b); });
}

}  // namespace

IioSettings read_iio_settings(SettingsTable& table) {
    IioSettings s;
    s.uri = table.text("uri", s.uri);
    if (!is_uri(s.uri))
        table.fail("uri", "\"" + s.uri + "\" is not allowed: expected local:, ip:host, ip:host:port or usb:");
    s.device = table.text("device", "");
    if (table.has("channels")) s.channels = table.texts("channels", 1, 3);
    for (auto c = s.channels.begin(); c != s.channels.end(); ++c)
        if (std::find(s.channels.begin(), c, *c) != c)
            table.fail("channels", "channel \"" + *c + "\" is given twice");
    if (table.has("rate_hz")) s.rate_hz = table.number("rate_hz", {0.1, 1e6});
    s.trigger = table.text("trigger", "");
    s.buffer_samples = table.integer("buffer_samples", 1, 65536, s.buffer_samples);
    s.kernel_buffers = table.integer("kernel_buffers", 1, 64, s.kernel_buffers);
    s.timeout_s = table.number("timeout_s", {0.05, 60}, s.timeout_s);
    s.give_up_s = table.number("give_up_s", {0.1, 3600}, s.give_up_s);
    const std::size_t otherwise = s.uri.starts_with("local:") ? 0 : 1;
    constexpr std::array kinds{IioStamps::host, IioStamps::device, IioStamps::none};
    s.stamps = kinds.at(table.choice("stamps", {"host", "device", "none"}, otherwise));
    s.gravity = table.flag("gravity", s.gravity);
    s.response = read_response(table, s.gravity);
    s.shaker_axis = read_shaker_axis(table, s.channels.size());
    s.clock_uncertainty_s = table.number("clock_uncertainty_s", {0, 3600}, s.clock_uncertainty_s);
    if (table.has("range_mps2")) s.range_mps2 = table.number("range_mps2", {1e-6, 1e6});
    return s;
}

}  // namespace shaker::iio
